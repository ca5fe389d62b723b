"""Fit a tip's outline to the picture: where the needle ends, and its shape.

All pixels around the tip are compared with a picture of the outline. Brightness is linear and
eliminated; the place along the axis, a shift across it, the width and the shape are found by
Levenberg and Marquardt's method, with the shaft's fit as prior. Of several families of tips the one
that describes the picture best for its number of parameters is taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.outline import Family
from simtip.detect.subpixel.picture import Cover, Placed, Window, cover, shading
from simtip.detect.subpixel.shaft import RIM_DEVIATION, RIM_LEVEL, Shaft
from simtip.geometry import Array

SIDE_PX, BELOW_PX = 6, 8
BRIGHTNESS_DEVIATION = 0.3
SLOPE_LEVER = 0.2

COMPLEXITY = 3.0
"""Weight of the penalty for each parameter of a shape; 1 is the Bayesian information criterion's. A
freer shape scatters more, so it has to describe the picture clearly better."""

SETTLED = 0.05
"""Change of the cost at which a fit ends."""

BLURRED_WIDTH = 0.3
"""How far the shaft's half width may be off in a blurred picture, px."""

AHEAD_PX = (0.0, 2.5, 5.0)
MOST_STEPS = 25
POSE = 3
"""Parameters before the shape: row v of z = 0 on the axis, shift across, half width."""


@dataclass(frozen=True, eq=False)
class TipFit:
    """A fitted tip in the turned image.

    Attributes
    ----------
    family
        Which outline.
    values
        Row of the foremost point's z on the axis, shift across, half width, shape.
    covariance
        Of them.
    tip
        (2,) u, v of the apex.
    tip_covariance
        (2, 2) px^2 of it.
    cost
        -2 log likelihood.
    misfit
        Mean squared residual over the noise.
    residual
        (H W,) gray values less the fit.
    """

    family: Family
    values: Array
    covariance: Array
    tip: Array
    tip_covariance: Array
    cost: float
    misfit: float
    residual: Array

    def better_than(self, other: TipFit) -> bool:
        """Say whether it describes the same pixels better, for its number of parameters.

        What both leave unexplained counts as noise.
        """
        unexplained = max(1.0, min(self.misfit, other.misfit))
        more = len(self.values) - len(other.values)
        penalty = COMPLEXITY * more * float(np.log(len(self.residual)))
        return (self.cost - other.cost) / unexplained + penalty < 0


@dataclass(frozen=True, eq=False)
class Scenery:
    """What a tip is fitted to.

    Attributes
    ----------
    window
        Which pixels.
    value
        (H W,) their gray values.
    shaft
        The shaft's fit.
    shift_deviation, half_deviation
        Of the shaft's axis at the tip, px, and of its half width.
    variance_px2
        Of the blur at the tip.
    level
        Of the background, DN.
    tilt
        Sine of the axis, towards the hub, along the line of sight.
    slope_deviation
        Of the axis' slope du/dv at the tip.
    """

    window: Window
    value: Array
    shaft: Shaft
    shift_deviation: float
    half_deviation: float
    half_px: float
    variance_px2: float
    level: float
    tilt: float
    slope_deviation: float

    def place(self, family: Family, values: Array) -> Placed:
        """Put an outline into the image."""
        v, shift, half = values[:POSE]
        slope = float(self.shaft.slope(np.array(v)))
        hub = np.array([-slope, -1.0]) / np.hypot(1, slope)
        across = np.array([-hub[1], hub[0]])
        origin = np.array([float(self.shaft.axis_u(np.array(v))), v]) + shift * across
        end = (v - self.window.v + 20.0) * 1.5
        outline = family.polygon(half, values[POSE:], end, self.tilt)
        corners = origin + outline[:, :1] * across + outline[:, 1:] * hub
        facet = None
        if family.facet is not None:
            drawn = family.facet(half, values[POSE:], self.tilt)
            facet = origin + drawn[:, :1] * across + drawn[:, 1:] * hub
        return Placed(corners, facet, origin, hub, half, family.depth(half, values[POSE:]))

    def apex(self, family: Family, values: Array) -> Array:
        """Give u, v of the apex (2,)."""
        placed = self.place(family, values)
        across = np.array([-placed.hub[1], placed.hub[0]])
        x, z = family.apex(values[2], values[POSE:], self.tilt)
        return np.asarray(placed.origin + x * across + z * placed.hub)

    def cover(self, family: Family, values: Array) -> Cover:
        """Work out what an outline covers."""
        return cover(self.place(family, values), self.window, self.variance_px2)


def fit_tip(
    scenery: Scenery,
    family: Family,
    v_end: float,
    begin: Array,
    known: list[Array] | None = None,
) -> TipFit:
    """Fit one family from a start.

    Parameters
    ----------
    scenery
        The pixels and the shaft.
    family
        The outline.
    v_end
        The last row that shows the needle.
    begin
        What the edges suggest.
    known
        Further values to begin with, if their family has as many.
    """
    low = np.array([-np.inf, -np.inf, 0.5, *family.low])
    high = np.array([np.inf, np.inf, np.inf, *family.high])
    values, found = _best_start(scenery, family, v_end, begin, known or [])
    damping = 1e-2
    derivative = None
    for _ in range(MOST_STEPS):
        if derivative is None:
            derivative = _derivative(scenery, family, values, found, high)
            H, g = _shape_equations(scenery, values, found, derivative)
        step = np.linalg.solve(H + damping * np.diag(np.diag(H)), g)
        step[:POSE] = np.clip(step[:POSE], -3, 3)
        tried = np.clip(values + step, low, high)
        there = _compare(scenery, family, tried)
        if not there.cost < found.cost:
            damping *= 8
            if damping > 1e4:
                break
            continue
        settled = found.cost - there.cost < SETTLED
        values, found, derivative = tried, there, None
        damping = max(damping / 8, 1e-5)
        if settled:
            break
    derivative = _derivative(scenery, family, values, found, high)
    H, _ = _shape_equations(scenery, values, found, derivative)
    free = ~((values <= low + 1e-9) | (values >= high - 1e-9))
    covariance = np.zeros_like(H)
    covariance[np.ix_(free, free)] = np.linalg.inv(H[np.ix_(free, free)])
    tip = scenery.apex(family, values)
    turn = np.zeros((2, len(values)))
    for k in range(len(values)):
        moved = values.copy()
        moved[k] += 1e-4
        turn[:, k] = (scenery.apex(family, moved) - tip) / 1e-4
    return TipFit(
        family,
        values,
        covariance,
        tip,
        turn @ covariance @ turn.T + _of_slope(scenery),
        found.cost,
        found.misfit,
        found.residual,
    )


def _of_slope(scenery: Scenery) -> Array:
    """Give what the axis' uncertain slope, which the fit takes as known, adds to the covariance.

    The tip is held by its flanks; it moves across by a third of their length times the slope.
    """
    lever = scenery.window.height * SLOPE_LEVER
    v = np.array(float(scenery.window.v + scenery.window.height))
    slope = float(scenery.shaft.slope(v))
    across = np.array([1.0, -slope]) / np.hypot(1, slope)
    return np.asarray((lever * scenery.slope_deviation) ** 2 * np.outer(across, across))


def _best_start(
    scenery: Scenery, family: Family, v_end: float, begin: Array, known: list[Array]
) -> tuple[Array, _Compared]:
    """Try starts: also further on, as the last row that shows the needle falls short of its end."""
    starts = [
        np.array([v_end + ahead, 0.0, scenery.half_px, *shape])
        for ahead in AHEAD_PX
        for shape in family.starts(begin)
    ]
    starts += [values for values in known if len(values) == POSE + len(family.low)]
    compared = [_compare(scenery, family, values) for values in starts]
    best = int(np.argmin([one.cost for one in compared]))
    return starts[best], compared[best]


@dataclass(frozen=True, eq=False)
class _Compared:
    columns: Array
    amplitude: Array
    weight: Array
    residual: Array
    precision: Array
    wanted: Array
    cost: float
    misfit: float
    normal: Array
    levels: tuple[Array, Array, Array]
    cover: Cover


def _compare(scenery: Scenery, family: Family, values: Array) -> _Compared:
    covered = scenery.cover(family, values)
    placed = scenery.place(family, values)
    ground, shaft, tip = shading(placed, scenery.window, scenery.variance_px2)
    open_part = (1 - covered.whole)[:, None]
    on_tip = covered.tip[:, None]
    on_shaft = (covered.whole - covered.tip)[:, None]
    columns = np.concatenate([open_part * ground, on_shaft * shaft, on_tip * tip], axis=1)
    weight = 1 / (scenery.shaft.noise[0] + scenery.shaft.noise[1] * np.clip(scenery.value, 0, None))
    precision, wanted = _prior(scenery.level, ground.shape[1], shaft.shape[1], tip.shape[1])
    weighted = columns * weight[:, None]
    normal = weighted.T @ columns + np.diag(precision)
    amplitude = np.linalg.solve(normal, weighted.T @ scenery.value + precision * wanted)
    residual = scenery.value - columns @ amplitude
    chi2 = float((residual**2 * weight).sum())
    cost = chi2 + float((precision * (amplitude - wanted) ** 2).sum()) + _off(scenery, values)
    a, b = ground.shape[1], ground.shape[1] + shaft.shape[1]
    levels = ground @ amplitude[:a], shaft @ amplitude[a:b], tip @ amplitude[b:]
    return _Compared(
        columns,
        amplitude,
        weight,
        residual,
        precision,
        wanted,
        cost,
        chi2 / len(residual),
        normal,
        levels,
        covered,
    )


def _prior(level: float, ground: int, shaft: int, tip: int) -> tuple[Array, Array]:
    """Give precision and mean of the amplitudes: background, shaft, tip."""
    usual = BRIGHTNESS_DEVIATION * level
    deviation = np.concatenate(
        [
            [1e3 * level],
            np.full(ground - 1, level),
            [2 * RIM_DEVIATION * level],
            np.full(shaft - 1, usual),
            [3 * RIM_DEVIATION * level],
            np.full(tip - 1, usual),
        ]
    )
    mean = np.zeros(len(deviation))
    mean[ground] = mean[ground + shaft] = RIM_LEVEL * level
    return 1 / deviation**2, mean


def _off(scenery: Scenery, values: Array) -> float:
    shift = values[1] / scenery.shift_deviation
    half = (values[2] - scenery.half_px) / scenery.half_deviation
    return float(shift**2 + half**2)


def _derivative(
    scenery: Scenery, family: Family, values: Array, found: _Compared, high: Array
) -> Array:
    """Give the derivative of the picture (H W, n) at fixed brightness, by differences."""
    derivative = np.empty((len(scenery.value), len(values)))
    ground, shaft, tip = found.levels
    for k in range(len(values)):
        step = 0.04 if k < POSE else 0.02
        moved = values.copy()
        moved[k] += step if values[k] + step <= high[k] else -step
        there = scenery.cover(family, moved)
        whole = (there.whole - found.cover.whole) / (moved[k] - values[k])
        on_tip = (there.tip - found.cover.tip) / (moved[k] - values[k])
        derivative[:, k] = whole * (shaft - ground) + on_tip * (tip - shaft)
    return derivative


def _shape_equations(
    scenery: Scenery, values: Array, found: _Compared, derivative: Array
) -> tuple[Array, Array]:
    """Give normal matrix and right side of the values, the brightness eliminated."""
    weighted = derivative * found.weight[:, None]
    cross = found.columns.T @ weighted
    eliminated = np.linalg.solve(found.normal, cross)
    H = derivative.T @ weighted - cross.T @ eliminated
    g = weighted.T @ found.residual
    # The brightness is at its best, so its own gradient is nothing.
    g = g - eliminated.T @ (
        found.columns.T @ (found.weight * found.residual)
        - found.precision * (found.amplitude - found.wanted)
    )
    H[1, 1] += 1 / scenery.shift_deviation**2
    g[1] -= values[1] / scenery.shift_deviation**2
    H[2, 2] += 1 / scenery.half_deviation**2
    g[2] -= (values[2] - scenery.half_px) / scenery.half_deviation**2
    H[np.arange(POSE, len(values)), np.arange(POSE, len(values))] += 1e-2
    return H, g


def window_about(
    shape: tuple[int, ...], shaft: Shaft, half: float, v_end: float, depth: float, spread: float
) -> Window:
    """Choose the pixels to compare: around the tip and some of the shaft."""
    low_v = int(max(0, np.floor(v_end - depth - 6)))
    high_v = int(min(shape[0] - 1, np.ceil(v_end + BELOW_PX + spread)))
    ends = shaft.axis_u(np.array([low_v, high_v], np.float64))
    side = half * float(np.hypot(1, shaft.slope(np.array(v_end)))) + SIDE_PX + spread
    low_u = int(max(0, np.floor(ends.min() - side)))
    high_u = int(min(shape[1] - 1, np.ceil(ends.max() + side)))
    return Window(low_u, low_v, high_u - low_u + 1, high_v - low_v + 1)


def scenery_of(
    image: NDArray[np.float32], shaft: Shaft, v_end: float, depth: float, level: float, tilt: float
) -> Scenery:
    """Gather what a tip is fitted to."""
    variance = float(shaft.variance_px2(np.array(v_end)))
    half = float(shaft.half_px(np.array(v_end)))
    window = window_about(image.shape, shaft, half, v_end, depth, 3 * np.sqrt(variance))
    part = image[window.v : window.v + window.height, window.u : window.u + window.width]
    t = float(shaft.t(np.array(v_end)))
    powers = t ** np.arange(len(shaft.axis))
    n = len(shaft.axis)
    spread = float(np.sqrt(powers @ shaft.covariance[:n, :n] @ powers))
    m = len(shaft.width)
    wide = t ** np.arange(m)
    half_deviation = float(np.sqrt(wide @ shaft.covariance[n : n + m, n : n + m] @ wide))
    steeper = np.arange(n) * t ** np.maximum(np.arange(n) - 1, 0) / shaft.scale
    slope_deviation = float(np.sqrt(steeper @ shaft.covariance[:n, :n] @ steeper))
    return Scenery(
        window,
        part.reshape(-1).astype(np.float64),
        shaft,
        float(np.hypot(spread, 0.002 + 0.01 * np.sqrt(variance))),
        max(half_deviation, 0.01) + BLURRED_WIDTH * variance / (variance + 0.1),
        half,
        variance,
        level,
        tilt,
        slope_deviation,
    )
