"""The straight or slightly bent shaft of a needle in the turned image: axis, width, blur, noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.detect.subpixel.edge_table import INSIDE, modes
from simtip.geometry import Array


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
    disc_share
        Of the blur's variance, what is a disc's, see `simtip.detect.subpixel.blur`.
    noise
        (3,) variance of a pixel's gray value, DN^2: constant, per DN and per DN^2.
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
    disc_share: float = 0.0

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

    def axis_at(self, v: float) -> tuple[float, float]:
        """Give u and slope du/dv of the axis at one row (quicker than `axis_u` and `slope`)."""
        t, u, rate = (v - self.origin) / self.scale, 0.0, 0.0
        for one in self.axis[::-1].tolist():
            rate = rate * t + u
            u = u * t + one
        return u, rate / self.scale

    def axis_covariance(self, v: float) -> Array:
        """Give the covariance (2, 2) of the axis' u and slope du/dv at a row."""
        t, n = float(self.t(np.array(v))), len(self.axis)
        k = np.arange(n)
        powers = t ** np.maximum(np.stack([k, k - 1]), 0)
        by_axis = powers * np.stack([np.ones(n), k / self.scale])
        return np.asarray(by_axis @ self.covariance[:n, :n] @ by_axis.T)

    def half_px(self, v: Array) -> Array:
        """Give half the width across the axis at rows v."""
        return _polynomial(self.t(v), self.width)

    def variance_px2(self, v: Array) -> Array:
        """Give the blur's variance at rows v; beyond both ends it stays as it is there."""
        share = np.clip(-self.t(v), 0, 1)
        return np.asarray(self.variance[0] * (1 - share) + self.variance[1] * share, np.float64)

    def noise_dn2(self, level: Array | float) -> Array:
        """Give the variance of pixels' gray values at levels, DN."""
        return _polynomial(np.maximum(level, 0.0), self.noise)

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
