"""Fit the needle's shaft: axis, width and blur, from all pixels near its two edges.

The shaft is cut into blocks of rows, and the pixels of a block are averaged in narrow bins of their
distance from the axis. In each block the background is free; the brightness within, the axis, the
width and the blur follow polynomials along the needle. Steps are Levenberg and Marquardt's; from
their equations the background is eliminated block by block.

What is asymmetric moves the axis, what is symmetric does not: a wrong width or a wrong shape of the
blur costs little. So the brightness at both edges, which together with width and blur is poorly
known in a blurred picture, is held by a prior.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.edge_table import (
    INSIDE,
    OUTSIDE,
    EdgeTable,
    modes,
)
from simtip.geometry import Array

BLOCK_ROWS, LEAST_BLOCKS = 48, 4
"""Rows of a block; a shaft of fewer such blocks has smaller ones, or else nothing would tell its
slope."""

BIN_PX = 1 / 8
BINS_MERGED = 2
INNER_PX, OUTER_PX = 4.5, 5.0
"""Pixels so far inside and outside an edge count, and three deviations of the blur more."""

SEGMENTS, EVEN_PX2 = 3, 0.05
"""Of the shaft, each with a blur of its own in the tables, if it changes by more than that."""

BRIGHTNESS_DEGREE = 2
"""Of the brightness along the needle."""

BRIGHTNESS_SHARE = 0.15
"""Usual deviation of the brightness within, of the background's level."""

CHANGE_SHARE = 0.3
"""Of that, its usual change along the shaft, for each power."""

RIM_LEVEL, RIM_DEVIATION = 0.48, 0.08
"""Brightness at the edges, of the background's, and its usual deviation: there rough metal mirrors
what is behind it, 0.39 to 0.6 of it for GGX roughness 0.4 to 0.05."""

HELD_PX = 1e-3

EDGE_BIN_PX, EDGE_DEPTH_PX = 0.25, 4.0

FIRST_STEPS, LAST_STEPS = 8, 20

SETTLED = 0.05
"""Change of the cost, a log likelihood times -2, over the misfit at which the fit ends."""

FIRST_MISFIT = 12.0
"""A shaft that fits so well after the first start's steps is not looked for from others."""

BEND_PX = (3.0, 0.3)
"""Usual deviation of the axis' quadratic and cubic coefficients."""

TRUSTED = 8.0
"""Blocks with a larger mean squared misfit, dirt or a thing's shadow, count less: the cost of a
block is logarithmic beyond it (Cauchy's)."""

NOISE_BINS = 12
LEAST_NOISE_DN2 = 0.02

LEAST_VARIANCE_PX2 = 0.003

SHAPE = 3
"""Parameters of the shape in a block: shift, half width, variance of the blur."""


@dataclass(frozen=True, eq=False)
class Shaft:
    """A fitted shaft in the turned image.

    With t = (v - origin) / scale, u of the axis is ``polyval(t, axis)``.

    Attributes
    ----------
    origin, scale
        Of t, rows.
    axis, width
        Coefficients, constant first: u of the axis, half width across it.
    variance
        (2,) variance of the blur at t = 0 and at t = -1; in between it is linear.
    noise
        (2,) variance of a pixel's gray value: constant, and per DN.
    covariance
        Of the coefficients of axis, width and variance, in this order.
    misfit
        Median over blocks of the mean squared residual over the noise.
    """

    origin: float
    scale: float
    axis: Array
    width: Array
    variance: Array
    noise: Array
    covariance: Array
    misfit: float
    cost: float = np.inf
    shared: Array | None = None
    width_held: bool = False

    def t(self, v: Array) -> Array:
        """Give the polynomials' argument at rows."""
        return np.asarray((v - self.origin) / self.scale, np.float64)

    def axis_u(self, v: Array) -> Array:
        """Give u of the axis at rows v."""
        return _polynomial(self.t(v), self.axis)

    def slope(self, v: Array) -> Array:
        """Give du/dv of the axis at rows v."""
        rate = self.axis[1:] * np.arange(1, len(self.axis)) / self.scale
        return _polynomial(self.t(v), rate)

    def half_px(self, v: Array) -> Array:
        """Give half the width across the axis at rows v."""
        return _polynomial(self.t(v), self.width)

    def variance_px2(self, v: Array) -> Array:
        """Give the blur's variance at rows v; beyond both ends it stays as it is there."""
        share = np.clip(-self.t(v), 0, 1)
        return np.asarray(self.variance[0] * (1 - share) + self.variance[1] * share, np.float64)

    def brightness(self, v: float) -> Array:
        """Give the brightness within at a row, DN, over the angles of `edge_table.modes`."""
        if self.shared is None:
            raise ValueError("the shaft has not been fitted")
        t = float(np.clip(self.t(np.array(v)), -1, 0))
        coefficients = self.shared.reshape(-1, INSIDE)
        return np.asarray(modes()[1] @ (t ** np.arange(len(coefficients)) @ coefficients))


def _polynomial(t: Array, coefficients: Array) -> Array:
    """Give a polynomial's values, constant first (Horner; numpy's own takes longer to begin)."""
    found = np.full(np.shape(t), coefficients[-1])
    for one in coefficients[-2::-1]:
        found = found * t + one
    return np.asarray(found)


@dataclass(frozen=True, eq=False)
class _Bins:
    """Pixels near both edges, averaged: (blocks, bins).

    Distance from the axis that they were sorted by, across it, px; gray value; number of pixels;
    and of each block the row, and u of that axis there.
    """

    x: Array
    value: Array
    count: Array
    v: Array
    axis_u: Array


def fit(
    image: NDArray[np.float32],
    rows: NDArray[np.intp],
    starts: list[Shaft],
    likely: Callable[[Shaft], bool],
) -> Shaft:
    """Fit a shaft to rows of the turned gray image (H, W).

    Parameters
    ----------
    image
        Gray values, turned.
    rows
        Consecutive rows; those beyond whole blocks are dropped at the front.
    starts
        Shafts good to a pixel, of different blur. A few steps are taken from each; the best of
        those goes on.
    likely
        Says of a shaft whether it can be; if none can, the width is held where the starts have it.
    """
    rows = rows[len(rows) % _block_rows(rows) :]
    noise = _noise(image, rows, starts[0])
    free = [replace(start, noise=noise) for start in starts]
    best = _best_of(image, rows, free, likely)
    if best is not None:
        ended = _settled(_sorted(image, rows, best), best, LAST_STEPS)
        if likely(ended):
            return ended
    held = [replace(start, width_held=True) for start in free]
    best = _best_of(image, rows, held, lambda _: True) or held[0]
    return _settled(_sorted(image, rows, best), best, LAST_STEPS)


def _best_of(
    image: NDArray[np.float32],
    rows: NDArray[np.intp],
    starts: list[Shaft],
    likely: Callable[[Shaft], bool],
) -> Shaft | None:
    """Take the first steps from starts, until from one they lead to a likely shaft that fits."""
    tried = []
    for start in starts:
        one = _first_settled(_sorted(image, rows, start), start)
        if likely(one):
            tried.append(one)
            if one.misfit < FIRST_MISFIT:
                break
    return min(tried, key=lambda one: one.cost, default=None)


def _block_rows(rows: NDArray[np.intp]) -> int:
    return max(1, min(BLOCK_ROWS, len(rows) // LEAST_BLOCKS))


def edge_half_px(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> float:
    """Give the half width at which the mean profile is halfway between ground and needle, px.

    It is less exact than a fit, and free of the fit's trade between width, blur and brightness.
    """
    bins = _sorted(image, rows[len(rows) % _block_rows(rows) :], shaft)
    away = np.abs(bins.x).reshape(-1)
    k = np.rint(away / EDGE_BIN_PX).astype(np.intp)
    number = np.bincount(k, bins.count.reshape(-1))
    total = np.bincount(k, (bins.count * bins.value).reshape(-1))
    seen = np.flatnonzero(number)
    x, value = seen * EDGE_BIN_PX, total[seen] / number[seen]
    half = float(shaft.width[0])
    ground = float(np.median(value[x > half + 2])) if (x > half + 2).any() else float(value[-1])
    within = (x > half - EDGE_DEPTH_PX) & (x < half)
    if not within.any():
        return half
    dark = int(np.flatnonzero(within)[np.argmax(np.abs(value[within] - ground))])
    share = (value[dark:] - ground) / (value[dark] - ground)
    (below,) = np.nonzero(share < 0.5)
    if not len(below) or below[0] == 0:
        return half
    j = int(below[0])
    step = (share[j - 1] - 0.5) / (share[j - 1] - share[j])
    return float(x[dark + j - 1] + step * (x[dark + j] - x[dark + j - 1]))


def _first_settled(bins: _Bins, start: Shaft) -> Shaft:
    """Take the first steps, with blocks and bins merged: the least cost needs no more."""
    return _settled(_merged(bins), start, FIRST_STEPS)


def _merged(bins: _Bins) -> _Bins:
    """Merge neighbouring bins, and blocks until `LEAST_BLOCKS` to twice as many are left."""
    tall = max(1, len(bins.v) // LEAST_BLOCKS)
    first = len(bins.v) % tall
    odd = bins.count.shape[1] % BINS_MERGED
    shape = (-1, tall, bins.count.shape[1] // BINS_MERGED, BINS_MERGED)

    def summed(values: Array) -> Array:
        kept = values[first:, : values.shape[1] - odd]
        return np.asarray(kept.reshape(shape).sum(axis=(1, 3)))

    count = summed(bins.count)
    there = np.maximum(count, 1)
    x, value = (summed(each * bins.count) / there for each in (bins.x, bins.value))
    v, axis_u = (each[first:].reshape(-1, tall).mean(axis=1) for each in (bins.v, bins.axis_u))
    return _Bins(x, value, count, v, axis_u)


def _settled(bins: _Bins, start: Shaft, most: int) -> Shaft:
    """Step to the least cost (Levenberg and Marquardt)."""
    best, found = start, _equations(bins, start)
    damping = 1e-3
    for _ in range(most):
        step = found.step(damping, best.variance - LEAST_VARIANCE_PX2)
        enough = SETTLED * max(1.0, found.misfit)
        if float(step @ found.g[found.first :]) < enough:
            break
        tried = _moved(best, step)
        there = _equations(bins, tried)
        if not there.cost < found.cost:
            damping *= 10
            if damping > 1e4:
                break
            continue
        settled = found.cost - there.cost < enough
        best, found = tried, there
        damping = max(damping / 10, 1e-6)
        if settled:
            break
    return replace(
        best,
        covariance=found.covariance(),
        misfit=found.misfit,
        cost=found.cost,
        shared=found.shared,
    )


def _moved(shaft: Shaft, step: Array) -> Shaft:
    a = len(shaft.axis)
    b = a + len(shaft.width)
    return replace(
        shaft,
        axis=shaft.axis + step[:a],
        width=shaft.width + step[a:b],
        variance=np.maximum(shaft.variance + step[b:], LEAST_VARIANCE_PX2),
    )


def _sorted(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> _Bins:
    """Average the pixels near the edges by block and by distance from the axis."""
    v = rows.astype(np.float64)
    centre, tilt = shaft.axis_u(v), np.hypot(1, shaft.slope(v))
    half = shaft.half_px(v)
    spread = 3 * np.sqrt(float(shaft.variance.max()))
    inner = min(INNER_PX + spread, float(half.min()))
    first = np.rint(centre - (half + OUTER_PX + spread) * tilt).astype(np.intp)
    count = int(np.ceil(2 * float(((half + OUTER_PX + spread) * tilt).max()))) + 1
    u = first[:, None] + np.arange(count)
    x = (u - centre[:, None]) / tilt[:, None]
    away = np.abs(x) - half[:, None]
    wanted = (away > -inner) & (away < OUTER_PX + spread) & (u >= 0) & (u < image.shape[1])
    value = image[rows[:, None], np.clip(u, 0, image.shape[1] - 1)]
    height = _block_rows(rows)
    blocks = len(rows) // height
    block = np.minimum(np.arange(len(rows)) // height, blocks - 1)
    reach = int(np.ceil((float(half.max()) + OUTER_PX + spread + 1) / BIN_PX))
    k = (np.rint(x / BIN_PX).astype(np.intp) + reach + block[:, None] * (2 * reach + 1))[wanted]
    total = blocks * (2 * reach + 1)
    number = np.bincount(k, minlength=total).astype(np.float64)
    there = np.maximum(number, 1)
    mean_x = np.bincount(k, x[wanted], total) / there
    mean_y = np.bincount(k, value[wanted], total) / there
    used = number.reshape(blocks, -1).any(axis=0)
    shape = (blocks, 2 * reach + 1)
    rows_of = np.bincount(block, v) / np.bincount(block)
    return _Bins(
        mean_x.reshape(shape)[:, used],
        mean_y.reshape(shape)[:, used],
        number.reshape(shape)[:, used],
        rows_of,
        shaft.axis_u(rows_of),
    )


@dataclass(frozen=True, eq=False)
class _Equations:
    """Normal equations at a shaft: of the brightness first, of the shape from `first` on."""

    cost: float
    H: Array
    g: Array
    first: int
    misfit: float
    shared: Array

    def step(self, damping: float, room: Array) -> Array:
        """Give a damped Gauss-Newton step of the shape.

        `room` (2,) is how far the variances may fall; one that would fall further is held.
        """
        H = self.H + damping * np.diag(
            np.where(np.arange(len(self.H)) < self.first, 0, np.diag(self.H))
        )
        free = np.ones(len(H), np.bool_)
        step = np.zeros(len(H))
        for _ in range(3):
            step[free] = np.linalg.solve(H[np.ix_(free, free)], self.g[free])
            step[~free] = 0
            low = free.copy()
            low[-2:] &= step[-2:] < -room - 1e-12
            low[:-2] = False
            low &= np.append(np.zeros(len(H) - 2, np.bool_), room < 1e-6)
            if not low.any():
                break
            free &= ~low
        return np.asarray(step[self.first :])

    def covariance(self) -> Array:
        """Give the shape's covariance."""
        return np.asarray(np.linalg.inv(self.H)[self.first :, self.first :])


def _equations(bins: _Bins, shaft: Shaft) -> _Equations:
    blocks = len(bins.v)
    t = shaft.t(bins.v)
    own = shaft.half_px(bins.v)[:, None]
    half = float(np.mean(own))
    cosine = 1 / np.hypot(1, shaft.slope(bins.v))[:, None]
    scale = half / own
    x = (bins.x - (shaft.axis_u(bins.v) - bins.axis_u)[:, None] * cosine) * scale
    even = abs(shaft.variance[0] - shaft.variance[1]) < EVEN_PX2
    segments = 1 if even else SEGMENTS
    parts = [
        _profiles(shaft, x[part], bins.v[part], half)
        for part in np.array_split(np.arange(blocks), min(segments, blocks))
    ]
    value, by_x, by_variance = (np.concatenate(kind) for kind in zip(*parts, strict=True))
    y = bins.value
    powers = t[:, None] ** np.arange(BRIGHTNESS_DEGREE + 1)
    weight = bins.count / (shaft.noise[0] + shaft.noise[1] * np.clip(y, 0, None))
    precision, wanted = _prior(y, bins.count, powers.shape[1])
    amplitude, shared = _amplitudes(value, y, weight, powers, precision, wanted)
    fitted = _times(value, amplitude)
    gradient = _times(by_x, amplitude) * scale
    jacobian = np.stack(
        [
            -gradient * cosine,
            -gradient * x / half,
            _times(by_variance, amplitude) * scale**2,
        ],
        axis=2,
    )
    residual = y - fitted
    weight = bins.count / (shaft.noise[0] + shaft.noise[1] * np.clip(fitted, 0, None))
    chi2 = (residual**2 * weight).sum(axis=1) / np.maximum((weight > 0).sum(axis=1), 1)
    typical = float(np.median(chi2))
    trust = 1 / (1 + chi2 / TRUSTED)
    columns = np.concatenate([value[..., :INSIDE], jacobian, value[..., INSIDE:]], axis=2)
    normal, right = _normal(columns, residual, weight * trust[:, None], INSIDE + SHAPE)
    sizes = [len(shaft.axis), len(shaft.width), 2]
    first = INSIDE * powers.shape[1]
    design = np.zeros((blocks, INSIDE + SHAPE, first + sum(sizes)))
    for c in range(INSIDE):
        design[:, c, c:first:INSIDE] = powers
    at = first
    for c, n in enumerate(sizes[:2]):
        design[:, INSIDE + c, at : at + n] = t[:, None] ** np.arange(n)
        at += n
    share = np.clip(-t, 0, 1)
    design[:, INSIDE + 2, at : at + 2] = np.stack([1 - share, share], axis=1)
    H = (np.swapaxes(design, 1, 2) @ normal @ design).sum(axis=0)
    g = np.einsum("bki,bk->i", design, right)
    g[:first] += wanted - precision @ shared
    H[:first, :first] += precision
    shape_precision, off = _shape_prior(shaft, half)
    H[first:, first:] += np.diag(shape_precision)
    g[first:] -= shape_precision * off
    cost = float((TRUSTED * np.log1p(chi2 / TRUSTED) * (weight > 0).sum(axis=1)).sum())
    cost += float(shared @ precision @ shared - 2 * wanted @ shared)
    cost += float((shape_precision * off**2).sum())
    return _Equations(cost, H, g, first, typical, shared)


def _profiles(shaft: Shaft, x: Array, v: Array, half: float) -> Array:
    """Give profile and derivatives (3, blocks, bins, columns) of some neighbouring blocks."""
    middle = np.array(float(v.mean()))
    variance = float(shaft.variance_px2(middle))
    slope = float(shaft.slope(middle))
    table = EdgeTable.build(half, float(np.abs(x).max()) + 0.1, slope, variance)
    found = np.moveaxis(table.at(x.reshape(-1)).reshape(*x.shape, 3, -1), 2, 0)
    # Each block's own blur, in the table's scale.
    own = shaft.variance_px2(v) * (half / shaft.half_px(v)) ** 2
    found[0] += (own - variance)[:, None, None] * found[2]
    return found


def _prior(y: Array, count: Array, powers: int) -> tuple[Array, Array]:
    """Give the precision (n, n) of the brightness' prior, and precision times mean (n,)."""
    level = max(float(np.quantile(y[count > 0], 0.9)), 1.0)
    usual = BRIGHTNESS_SHARE * level
    weight = np.full((powers, INSIDE), 1 / (CHANGE_SHARE * usual) ** 2)
    weight[0] = 1 / usual**2
    weight[0, 0] = 1 / (RIM_DEVIATION * level) ** 2
    wanted = np.zeros(powers * INSIDE)
    wanted[0] = weight[0, 0] * RIM_LEVEL * level
    return np.diag(weight.reshape(-1)), wanted


def _shape_prior(shaft: Shaft, half: float) -> tuple[Array, Array]:
    """Give the precision of the shape's prior and how far the shape is off its mean: both weak."""
    bend = [0.0, 0.0, *BEND_PX[: len(shaft.axis) - 2]]
    change = [HELD_PX if shaft.width_held else 0.0, 0.1 * half, 0.005 * half]
    deviation = np.array([*bend, *change[: len(shaft.width)], 3.0, 3.0])
    now = np.concatenate([shaft.axis, shaft.width, shaft.variance])
    held = deviation > 0
    precision = np.where(held, 1 / np.where(held, deviation, 1.0) ** 2, 0.0)
    if shaft.width_held:
        now[len(shaft.axis)] = 0.0  # it stays where it is
    return precision, np.where(held, now, 0.0)


def _times(columns: Array, amplitude: Array) -> Array:
    """Give (blocks, bins) of columns (blocks, bins, n) and amplitudes (blocks, n)."""
    return np.asarray((columns @ amplitude[..., None])[..., 0])


def _normal(columns: Array, y: Array, weight: Array, keep: int) -> tuple[Array, Array]:
    """Give each block's normal equations in the first `keep` columns, the others eliminated."""
    weighted = np.swapaxes(columns * weight[..., None], 1, 2)
    N = weighted @ columns
    r = _times(weighted, y)
    B = N[:, keep:, :keep]
    E = np.swapaxes(np.linalg.solve(N[:, keep:, keep:] + 1e-9 * np.eye(OUTSIDE), B), 1, 2)
    return N[:, :keep, :keep] - E @ B, r[:, :keep] - _times(E, r[:, keep:])


def _amplitudes(
    value: Array, y: Array, weight: Array, powers: Array, precision: Array, wanted: Array
) -> tuple[Array, Array]:
    """Fit the brightness: within as polynomials of all blocks, the background of each.

    Returns
    -------
    amplitude, shared
        (blocks, columns), and the coefficients of those polynomials.
    """
    k, count = value.shape[2] - OUTSIDE, powers.shape[1]
    normal, right = _normal(value, y, weight, k)
    H = np.einsum("bi,bj,bkl->ikjl", powers, powers, normal, optimize=True)
    g = np.einsum("bi,bk->ik", powers, right).reshape(-1)
    shared = np.linalg.solve(H.reshape(count * k, count * k) + precision, g + wanted)
    inside = powers @ shared.reshape(count, k)
    rest = y - _times(value[..., :k], inside)
    outer = value[..., k:]
    weighted = np.swapaxes(outer * weight[..., None], 1, 2)
    outside = np.linalg.solve(weighted @ outer + 1e-9 * np.eye(OUTSIDE), weighted @ rest[..., None])
    return np.concatenate([inside, outside[..., 0]], axis=1), shared


def _noise(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> Array:
    """Give constant and slope of the noise's variance against the level, DN^2.

    From second differences along the needle, in which all that is smooth cancels; medians, so that
    dirt does not count.
    """
    v = rows.astype(np.float64)
    half = float(shaft.half_px(v).max())
    reach = np.arange(-int(half + OUTER_PX), int(half + OUTER_PX) + 1)
    # Along the axis, not along u: a slanting needle's edges would count as noise.
    columns = np.rint(shaft.axis_u(v)).astype(np.intp)[:, None] + reach
    values = image[rows[:, None], np.clip(columns, 0, image.shape[1] - 1)]
    above, at, below = values[:-2], values[1:-1], values[2:]
    off = ((above - 2 * at + below) ** 2 / 6).reshape(-1)
    level = ((above + at + below) / 3).reshape(-1)
    parts = np.array_split(np.argsort(level), NOISE_BINS)
    mean = np.array([level[part].mean() for part in parts])
    # The median of a squared normal number is 0.4549 of its mean.
    variance = np.array([np.median(off[part]) / 0.4549 for part in parts])
    slope = max(float(np.polyfit(mean, variance, 1)[0]), 0.0)
    constant = max(float(np.median(variance - slope * mean)), LEAST_NOISE_DN2)
    return np.array([constant, slope])
