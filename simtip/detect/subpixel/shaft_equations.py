"""How well a shaft describes its pixels, and which step describes them better.

In each block of rows the background is free; the brightness within, the axis, the width and the
blur follow polynomials along the needle. The background is eliminated block by block.

What is asymmetric moves the axis, what is symmetric does not: a wrong width or a wrong shape of the
blur costs little. So the brightness at both edges, which together with width and blur is poorly
known in a blurred picture, is held by a prior.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.detect.subpixel.edge_table import INSIDE, OUTSIDE, EdgeTables
from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.shaft_pixels import Bins
from simtip.geometry import Array

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

BEND_PX = (3.0, 0.3)
"""Usual deviation of the axis' quadratic and cubic coefficients."""

TRUSTED = 8.0
"""Blocks with a larger mean squared misfit, dirt or a thing's shadow, count less: the cost of a
block is logarithmic beyond it (Cauchy's)."""

SHAPE = 3
"""Parameters of the shape in a block: shift, half width, variance of the blur; a fourth may be the
square of the disc's share in that."""

USUAL_SHARE, SHARE_DEVIATION = 0.5, 0.5
"""What that share usually is, and of its square the usual deviation."""

AT_END = 1e-6


@dataclass(frozen=True, eq=False)
class Equations:
    """Normal equations at a shaft: of the brightness first, of the shape from `first` on."""

    cost: float
    H: Array
    g: Array
    first: int
    misfit: float
    shared: Array

    def step(self, damping: float, low: Array, high: Array) -> tuple[Array, float]:
        """Give a damped Gauss-Newton step of the shape, and what it promises of the cost.

        What the brightness alone would gain, whose best depends on the weights, is no promise.
        `low` and `high` (n,) are how far the shape may go down and up; what is at its end is held.
        """
        H = self.H + damping * np.diag(
            np.where(np.arange(len(self.H)) < self.first, 0, np.diag(self.H))
        )
        free = np.ones(len(H), np.bool_)
        step = np.zeros(len(H))
        for _ in range(3):
            step[free] = np.linalg.solve(H[np.ix_(free, free)], self.g[free])
            step[~free] = 0
            shape = step[self.first :]
            beyond = ((low < AT_END) & (shape < 0)) | ((high < AT_END) & (shape > 0))
            if not beyond.any():
                break
            free[self.first :] &= ~beyond
        bright = self.g[: self.first]
        alone = float(bright @ np.linalg.solve(self.H[: self.first, : self.first], bright))
        return np.asarray(step[self.first :]), float(step @ self.g) - alone

    def covariance(self) -> Array:
        """Give the shape's covariance."""
        return np.asarray(np.linalg.inv(self.H)[self.first :, self.first :])


def equations_of(bins: Bins, shaft: Shaft, *, share: bool = False) -> Equations:
    """Work out the normal equations at a shaft: brightness at its best, each ground eliminated.

    With `share`, what the disc has of the blur is a parameter, too.
    """
    t = shaft.t(bins.v)
    own = shaft.half_px(bins.v)[:, None]
    half = float(np.mean(own))
    cosine = 1 / np.hypot(1, shaft.slope(bins.v))[:, None]
    scale = half / own
    x = (bins.x - (shaft.axis_u(bins.v) - bins.axis_u)[:, None] * cosine) * scale
    even = abs(shaft.variance[0] - shaft.variance[1]) < EVEN_PX2
    segments = 1 if even else SEGMENTS
    value, by_x, by_variance, *by_share = _profiles(shaft, x, bins.v, half, segments, share=share)
    y = bins.value
    powers = t[:, None] ** np.arange(BRIGHTNESS_DEGREE + 1)
    weight = bins.count / shaft.noise_dn2(y)
    precision, wanted = _prior(y, bins.count, powers.shape[1])
    amplitude, shared = _amplitudes(value, y, weight, powers, precision, wanted)
    fitted = _times(value, amplitude)
    gradient = _times(by_x, amplitude) * scale
    jacobian = np.stack(
        [
            -gradient * cosine,
            -gradient * x / half,
            _times(by_variance, amplitude) * scale**2,
            *(_times(one, amplitude) for one in by_share),
        ],
        axis=2,
    )
    residual = y - fitted
    weight = bins.count / shaft.noise_dn2(fitted)
    chi2 = (residual**2 * weight).sum(axis=1) / np.maximum((weight > 0).sum(axis=1), 1)
    typical = float(np.median(chi2))
    trust = 1 / (1 + chi2 / TRUSTED)
    columns = np.concatenate([value[..., :INSIDE], jacobian, value[..., INSIDE:]], axis=2)
    shape = jacobian.shape[2]
    normal, right = _normal(columns, residual, weight * trust[:, None], INSIDE + shape)
    design = _design(shaft, t, powers, shape)
    first = INSIDE * powers.shape[1]
    H = (np.swapaxes(design, 1, 2) @ normal @ design).sum(axis=0)
    g = np.einsum("bki,bk->i", design, right)
    g[:first] += wanted - precision @ shared
    H[:first, :first] += precision
    shape_precision, off = _shape_prior(shaft, half, share=share)
    H[first:, first:] += np.diag(shape_precision)
    g[first:] -= shape_precision * off
    cost = float((TRUSTED * np.log1p(chi2 / TRUSTED) * (weight > 0).sum(axis=1)).sum())
    cost += float(shared @ precision @ shared - 2 * wanted @ shared)
    cost += float((shape_precision * off**2).sum())
    return Equations(cost, H, g, first, typical, shared)


def _design(shaft: Shaft, t: Array, powers: Array, shape: int) -> Array:
    """Give what each block's brightness, shift, width and blur are of the coefficients.

    (blocks, INSIDE + shape, coefficients).
    """
    sizes = [len(shaft.axis), len(shaft.width), 2 + shape - SHAPE]
    first = INSIDE * powers.shape[1]
    design = np.zeros((len(t), INSIDE + shape, first + sum(sizes)))
    for c in range(INSIDE):
        design[:, c, c:first:INSIDE] = powers
    at = first
    for c, n in enumerate(sizes[:2]):
        design[:, INSIDE + c, at : at + n] = t[:, None] ** np.arange(n)
        at += n
    share = np.clip(-t, 0, 1)
    design[:, INSIDE + 2, at : at + 2] = np.stack([1 - share, share], axis=1)
    design[:, INSIDE + SHAPE :, at + 2 :] = 1.0
    return design


def _profiles(
    shaft: Shaft, x: Array, v: Array, half: float, segments: int, *, share: bool
) -> Array:
    """Give profile and derivatives (3 or 4, blocks, bins, columns), a segment's about one blur."""
    parts = np.array_split(np.arange(len(v)), min(segments, len(v)))
    middles = np.array([v[part].mean() for part in parts])
    variance = shaft.variance_px2(middles)
    reach = float(np.abs(x).max()) + 0.1
    slope = shaft.slope(middles)
    tables = EdgeTables.build(half, reach, slope, variance, shaft.disc_share, by_share=share)
    found = np.empty((SHAPE + share, *x.shape, INSIDE + OUTSIDE))
    for k, part in enumerate(parts):
        there = tables.at(x[part].reshape(-1), k).reshape(*x[part].shape, SHAPE + share, -1)
        found[:, part] = np.moveaxis(there, 2, 0)
    # Each block's own blur, in the tables' scale.
    own = shaft.variance_px2(v) * (half / shaft.half_px(v)) ** 2
    about = np.repeat(variance, [len(part) for part in parts])
    found[0] += (own - about)[:, None, None] * found[2]
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


def _shape_prior(shaft: Shaft, half: float, *, share: bool) -> tuple[Array, Array]:
    """Give the precision of the shape's prior and how far the shape is off its mean: both weak."""
    bend = [0.0, 0.0, *BEND_PX[: len(shaft.axis) - 2]]
    change = [*((HELD_PX, HELD_PX) if shaft.width_held else (0.0, 0.1 * half)), 0.005 * half]
    disc = [SHARE_DEVIATION] if share else []
    deviation = np.array([*bend, *change[: len(shaft.width)], 3.0, 3.0, *disc])
    off_disc = [shaft.disc_share**2 - USUAL_SHARE**2] if share else []
    now = np.concatenate([shaft.axis, shaft.width, shaft.variance, off_disc])
    held = deviation > 0
    precision = np.where(held, 1 / np.where(held, deviation, 1.0) ** 2, 0.0)
    if shaft.width_held:
        at = len(shaft.axis)
        now[at : at + min(2, len(shaft.width))] = 0.0  # they stay where they are
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
    products = (powers[:, :, None] * powers[:, None]).reshape(-1, count**2)
    H = (products.T @ normal.reshape(-1, k**2)).reshape(count, count, k, k).swapaxes(1, 2)
    g = (powers.T @ right).reshape(-1)
    shared: Array = np.linalg.solve(H.reshape(count * k, count * k) + precision, g + wanted).astype(
        np.float64
    )
    inside = powers @ shared.reshape(count, k)
    rest = y - _times(value[..., :k], inside)
    outer = value[..., k:]
    weighted = np.swapaxes(outer * weight[..., None], 1, 2)
    outside = np.linalg.solve(weighted @ outer + 1e-9 * np.eye(OUTSIDE), weighted @ rest[..., None])
    return np.concatenate([inside, outside[..., 0]], axis=1), shared
