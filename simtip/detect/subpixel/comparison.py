"""Compare an outline's picture with the pixels: how well it fits, and which way it fits better.

Brightness is linear and eliminated. Pixels that the needle does not touch show the background only,
and their share of the normal equations is what all would have, less what those near the needle do.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.brightness import (
    GROUND_COLUMNS,
    SHAFT_COLUMNS,
    TIP_COLUMNS,
    blurred_columns,
    shaft_columns,
    tip_columns,
)
from simtip.detect.subpixel.outline import Family
from simtip.detect.subpixel.picture import LEAST_COVER, Cover, Placed, cover_change
from simtip.detect.subpixel.scenery import BLUR, LEAN, POSE, SHIFT, Scenery
from simtip.detect.subpixel.shaft_equations import RIM_DEVIATION, RIM_LEVEL
from simtip.geometry import Array

BRIGHTNESS_DEVIATION = 0.3

STEP_PX, SHAPE_STEP = 0.05, 0.01
"""Of the differences: for the pose, and for the shape, half widths or radians."""

TILT_STEP = 0.005

SHAPE_PRECISION = 1e-2

WIDE_PX2 = 12.0
"""Variance of a blur that takes too long to be worked out for each mode: hardly a needle's."""

WITHIN = 0.98
"""Least cover of a pixel that is the needle's alone."""

HELD = 1e12
"""Precision of what stays as it is."""

SHAFT_END = GROUND_COLUMNS + SHAFT_COLUMNS
COLUMNS = SHAFT_END + TIP_COLUMNS
"""Of a pixel's brightness: background, shaft, tip."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """An outline held against the pixels.

    Attributes
    ----------
    near
        (n,) flat indices of the pixels that the needle touches, or nearly.
    columns
        (n, `COLUMNS`) what their brightness is made of, over the noise.
    normal
        (`COLUMNS`, `COLUMNS`) of the brightness, prior included.
    amplitude
        (`COLUMNS`,) DN, at its best.
    levels
        (n, 3) DN of background, shaft and tip, were each alone.
    residual
        (H W,) gray values less the fit, DN.
    cost
        -2 log likelihood.
    misfit
        Mean squared residual over the noise.
    placed, cover
        The outline in the image, and what it covers.
    """

    near: NDArray[np.intp]
    columns: Array
    normal: Array
    amplitude: Array
    levels: Array
    residual: Array
    cost: float
    misfit: float
    placed: Placed
    cover: Cover


def compare(scenery: Scenery, family: Family, values: Array) -> Comparison:
    """Hold an outline against the pixels, its brightness at its best."""
    placed = scenery.place(family, values)
    covered = scenery.cover(placed, values[BLUR])
    near = _near(covered, scenery)
    u, v = scenery.points(near)
    ground, value = (each[near] for each in scenery.weighted)
    precision = scenery.precision[near]
    whole, tip = covered.whole[near], covered.tip[near]
    if scenery.sharp or values[BLUR] > WIDE_PX2:
        bare = _averaged_columns(placed, u, v, (whole - tip, tip), values[BLUR])
    else:
        bare = blurred_columns(placed, scenery.brightness_cells(values[BLUR]))[near]
    columns = np.empty((len(near), COLUMNS))
    np.multiply(ground, (1 - whole)[:, None], out=columns[:, :GROUND_COLUMNS])
    on_shaft, on_tip = ((whole - tip) * precision)[:, None], (tip * precision)[:, None]
    np.multiply(bare[:, :SHAFT_COLUMNS], on_shaft, out=columns[:, GROUND_COLUMNS:SHAFT_END])
    np.multiply(bare[:, SHAFT_COLUMNS:], on_tip, out=columns[:, SHAFT_END:])
    normal, right = columns.T @ columns, columns.T @ value
    everywhere, everywhere_right = scenery.all_ground
    normal[:GROUND_COLUMNS, :GROUND_COLUMNS] += everywhere - ground.T @ ground
    right[:GROUND_COLUMNS] += everywhere_right - ground.T @ value
    prior, wanted = _prior(scenery.level)
    normal[np.arange(COLUMNS), np.arange(COLUMNS)] += prior
    amplitude: Array = np.linalg.solve(normal, right + prior * wanted).astype(np.float64)
    residual = scenery.value - scenery.ground @ amplitude[:GROUND_COLUMNS]
    levels = np.column_stack(
        [
            scenery.ground[near] @ amplitude[:GROUND_COLUMNS],
            bare[:, :SHAFT_COLUMNS] @ amplitude[GROUND_COLUMNS:SHAFT_END],
            bare[:, SHAFT_COLUMNS:] @ amplitude[SHAFT_END:],
        ]
    )
    shares = np.column_stack([1 - whole, whole - tip, tip])
    residual[near] = scenery.value[near] - (levels * shares).sum(axis=1)
    over_noise = residual * scenery.precision
    chi2 = float(over_noise @ over_noise)
    off = float(prior @ (amplitude - wanted) ** 2)
    return Comparison(
        near,
        columns,
        normal,
        amplitude,
        levels,
        residual,
        chi2 + off + _off(scenery, values),
        chi2 / scenery.counted,
        placed,
        covered,
    )


def _averaged_columns(
    placed: Placed, u: Array, v: Array, covers: tuple[Array, Array], variance_px2: float
) -> Array:
    """Give what the brightness of shaft and tip is made of at pixels (n,), 0 where none is seen.

    Averaged over as far as the blur reaches: quickly.
    """
    bare = np.zeros((len(u), COLUMNS - GROUND_COLUMNS))
    sides, reach = placed.sides_of(v), 0.5 + float(np.sqrt(variance_px2))
    for cover, parts, columns_of in (
        (covers[0], slice(SHAFT_COLUMNS), shaft_columns),
        (covers[1], slice(SHAFT_COLUMNS, None), tip_columns),
    ):
        (there,) = np.nonzero(cover > LEAST_COVER)
        bare[there, parts] = columns_of(placed, u[there], v[there], sides[:, there], reach)
    return bare


def _near(covered: Cover, scenery: Scenery) -> NDArray[np.intp]:
    """Find the pixels that an outline touches, or would if it moved a little."""
    touched = (covered.whole > LEAST_COVER).astype(np.uint8)
    shape = scenery.window.shape
    return np.flatnonzero(cv2.dilate(touched.reshape(shape), np.ones((3, 3), np.uint8)))


@lru_cache(maxsize=8)
def _prior(level: float) -> tuple[Array, Array]:
    """Give precision and mean of the amplitudes: background, shaft, tip."""
    usual = BRIGHTNESS_DEVIATION * level
    deviation = np.full(COLUMNS, usual)
    deviation[:GROUND_COLUMNS] = [1e3 * level, level, level]
    deviation[GROUND_COLUMNS] = 2 * RIM_DEVIATION * level
    deviation[SHAFT_END] = 3 * RIM_DEVIATION * level
    mean = np.zeros(COLUMNS)
    mean[GROUND_COLUMNS] = mean[SHAFT_END] = RIM_LEVEL * level
    return 1 / deviation**2, mean


def _off(scenery: Scenery, values: Array) -> float:
    axis = values[[SHIFT, LEAN]]
    half = (values[2] - scenery.half_px) / scenery.half_deviation
    blur = (values[BLUR] - scenery.variance_px2) / scenery.variance_deviation
    return float(axis @ scenery.axis_precision @ axis + half**2 + blur**2)


def derivative(
    scenery: Scenery, family: Family, values: Array, found: Comparison, high: Array
) -> Array:
    """Give the derivative of the picture near the needle at fixed brightness.

    Over the noise, (n, parameters). Of the outline by differences, of the blur as well.
    """
    steps = np.where(np.arange(len(values)) < POSE, STEP_PX, SHAPE_STEP)
    steps = np.where(values + steps <= high, steps, -steps)
    by_edges = [k for k in range(len(values)) if k not in (BLUR, LEAN)]
    moved = []
    for k in by_edges:
        other = values.copy()
        other[k] += steps[k]
        moved.append(scenery.place(family, other))
    cells = scenery.cells(values[BLUR])
    by_cover = cover_change(found.placed, moved, steps[by_edges], cells)
    change = np.zeros((len(found.near), len(values)))
    change[:, by_edges] = _by_cover(scenery, found, by_cover.whole.T, by_cover.tip.T)
    # A lean moves each row across, by its distance from where the axis is held.
    _, v = scenery.points(found.near)
    cosine = -found.placed.hub[1]
    change[:, LEAN] = change[:, SHIFT] * ((v - scenery.row) * cosine)
    if not scenery.sharp:
        there = scenery.cover(found.placed, values[BLUR] + steps[BLUR])
        change[:, BLUR] = (
            _by_cover(scenery, found, there.whole - found.cover.whole, there.tip - found.cover.tip)
            / steps[BLUR]
        )
    return change


def derivative_by_tilt(scenery: Scenery, family: Family, values: Array, found: Comparison) -> Array:
    """Give the derivative of the picture by the sight's tilt, as `derivative` does (n,)."""
    there = scenery.cover(scenery.tilted(TILT_STEP).place(family, values), values[BLUR])
    whole, tip = there.whole - found.cover.whole, there.tip - found.cover.tip
    return _by_cover(scenery, found, whole, tip) / TILT_STEP


def _by_cover(scenery: Scenery, found: Comparison, whole: Array, tip: Array) -> Array:
    """Give how the picture near the needle changes, over the noise, as covers (H W, ...) do."""
    ground, shaft, on_tip = found.levels.T * scenery.precision[found.near]
    changed = whole[found.near].T * (shaft - ground) + tip[found.near].T * (on_tip - shaft)
    return np.asarray(changed.T)


def shape_equations(
    scenery: Scenery, values: Array, found: Comparison, change: Array
) -> tuple[Array, Array]:
    """Give normal matrix and right side of the values, the brightness eliminated.

    The brightness is at its best, so its own gradient is nothing.
    """
    cross = found.columns.T @ change
    H = change.T @ change - cross.T @ np.linalg.solve(found.normal, cross)
    g = change.T @ (found.residual * scenery.precision)[found.near]
    axis = [SHIFT, LEAN]
    H[np.ix_(axis, axis)] += scenery.axis_precision
    g[axis] -= scenery.axis_precision @ values[axis]
    H[2, 2] += 1 / scenery.half_deviation**2
    g[2] -= (values[2] - scenery.half_px) / scenery.half_deviation**2
    if scenery.sharp:
        H[BLUR, BLUR] = HELD
    else:
        H[BLUR, BLUR] += 1 / scenery.variance_deviation**2
        g[BLUR] -= (values[BLUR] - scenery.variance_px2) / scenery.variance_deviation**2
    H[np.arange(POSE, len(values)), np.arange(POSE, len(values))] += SHAPE_PRECISION
    return H, g
