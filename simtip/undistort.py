"""Distortion undone along rays: one piece of arithmetic for the renderer and for its check.

`undo` needs nothing but + - * /, so the renderer runs it on its own numbers, and `plan` runs the
same steps in NumPy's single precision when a camera is made, to see how far each pixel's ray is
off. A lens that is not undone well enough is so refused before anything is rendered.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.camera import Camera, border
from simtip.geometry import Array

TOLERANCE_PX = 0.005
"""How far a rendered pixel may be from the projection of its ray."""

STEPS = (4, 8, 16)
"""Newton steps that are tried; four are enough for nearly all lenses."""

DEGREE = 5
"""Of the polynomial in the squared distorted radius from which Newton's method starts."""

_PROFILE = 400  # radii of the fit
_ACROSS = 128  # pixels checked along the shorter side, and several times as many along the border


@dataclass(frozen=True)
class Terms:
    """OpenCV's first eight coefficients, as plain numbers or as the renderer's."""

    k1: Any
    k2: Any
    p1: Any
    p2: Any
    k3: Any
    k4: Any
    k5: Any
    k6: Any

    def radial(self, r2: Any) -> tuple[Any, Any]:
        """Give the radial factor and its derivative with respect to r^2."""
        over = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        under = 1 + r2 * (self.k4 + r2 * (self.k5 + r2 * self.k6))
        d_over = self.k1 + r2 * (2 * self.k2 + r2 * 3 * self.k3)
        d_under = self.k4 + r2 * (2 * self.k5 + r2 * 3 * self.k6)
        return over / under, (d_over * under - over * d_under) / (under * under)


def terms(distortion: tuple[float, ...]) -> Terms:
    """Fill up OpenCV's coefficients to eight.

    Raises
    ------
    ValueError
        More than eight: thin prism and tilt are not among the terms.
    """
    if len(distortion) > 8:
        raise ValueError(f"{len(distortion)} coefficients: thin prism and tilt are not undone")
    return Terms(*distortion, *(0.0,) * (8 - len(distortion)))


def undo(x_d: Any, y_d: Any, model: Terms, start: tuple[Any, ...], steps: int) -> tuple[Any, Any]:
    """Find the (x, y) = (X/Z, Y/Z) that is distorted to (x_d, y_d), by Newton's method.

    Parameters
    ----------
    x_d, y_d
        Any numbers that can be added, multiplied and divided.
    model
        The distortion.
    start
        Coefficients c of the first guess, ``x = x_d (1 + c0 q + c1 q^2 + ..)``, q = x_d^2 + y_d^2.
    steps
        How many.
    """
    q = x_d * x_d + y_d * y_d
    guess = q * start[-1]
    for coefficient in reversed(start[:-1]):
        guess = (guess + coefficient) * q
    x, y = x_d * (1 + guess), y_d * (1 + guess)
    p1, p2 = model.p1, model.p2
    for _ in range(steps):
        r2 = x * x + y * y
        radial, slope = model.radial(r2)
        xy = x * y
        off_x = x * radial + 2 * p1 * xy + p2 * (r2 + 2 * x * x) - x_d
        off_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * xy - y_d
        xx = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x
        yy = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x
        cross = 2 * xy * slope + 2 * p1 * x + 2 * p2 * y
        inverse = 1 / (xx * yy - cross * cross)
        x, y = (
            x - (yy * off_x - cross * off_y) * inverse,
            y - (xx * off_y - cross * off_x) * inverse,
        )
    return x, y


@dataclass(frozen=True)
class Undistortion:
    """How a camera's distortion is undone.

    Attributes
    ----------
    start, steps
        As `undo` takes them.
    error_px
        The largest distance of a pixel from the projection of the ray found for it, in single
        precision; inf where none was found.
    """

    start: tuple[float, ...]
    steps: int
    error_px: float


def plan(camera: Camera) -> Undistortion:
    """Choose how to undo a camera's distortion, with as few steps as keep `TOLERANCE_PX`.

    If none do, the most steps are chosen and `Undistortion.error_px` tells. Checked are a grid
    over the image and its border, half a pixel out; the model has to be valid there, see
    `simtip.camera.folds`.
    """
    pixels = checked_pixels(camera)
    start = _first_guess(camera, pixels)
    for steps in STEPS:
        found = Undistortion(start, steps, round_trip_px(camera, pixels, start, steps))
        if found.error_px <= TOLERANCE_PX / 2:  # the renderer's rounding is not bit for bit this
            break
    return found


def round_trip_px(camera: Camera, pixels: Array, start: tuple[float, ...], steps: int) -> float:
    """Give the largest error of `undo` in single precision at some pixels (n, 2), px."""
    K = camera.K.astype(np.float32)
    x_d, y_d = (pixels.astype(np.float32) - K[:2, 2]).T / np.diag(K)[:2, None]
    single = Terms(*(np.float32(v) for v in vars(terms(camera.distortion)).values()))
    with np.errstate(all="ignore"):
        x, y = undo(x_d, y_d, single, tuple(np.float32(c) for c in start), steps)
        rays = np.column_stack([x, y, np.ones_like(x)]).astype(np.float64)
        error = np.abs(camera.project(rays) - pixels).max(axis=1)
    return float(np.where(np.isfinite(error), error, np.inf).max())


def checked_pixels(camera: Camera) -> Array:
    """Give a grid of pixels (n, 2) over the image and, four times denser, its outer border."""
    step = max(1.0, min(camera.size) / _ACROSS)
    w, h = camera.size
    u, v = (np.linspace(0, side - 1, int(np.ceil(side / step)) + 1) for side in (w, h))
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    return np.concatenate([grid, border(camera, max(1.0, step / 4))])


def _first_guess(camera: Camera, pixels: Array) -> tuple[float, ...]:
    """Fit the inverse of the radial part over the image: relative error spread evenly."""
    model = terms(camera.distortion)
    normalised = (pixels - camera.K[:2, 2]) / np.diag(camera.K)[:2]
    reach = float(np.linalg.norm(normalised, axis=1).max())
    r = _undistorted_radii(model, reach)
    distorted = r * model.radial(r**2)[0]
    q = (distorted / reach) ** 2
    powers = q[:, None] ** np.arange(1, DEGREE + 1)
    with np.errstate(all="ignore"):
        ratio = r / distorted - 1
    weight = distorted[:, None]
    scaled, *_ = np.linalg.lstsq(powers * weight, ratio * weight[:, 0], rcond=None)
    return tuple(float(c) / reach ** (2 * n) for n, c in enumerate(scaled, start=1))


def _undistorted_radii(model: Terms, reach: float) -> Array:
    """Give radii from the axis outwards whose distorted radii rise up to `reach`, or as far as."""
    r = reach * np.geomspace(1e-3, 100, 4000)
    with np.errstate(all="ignore"):
        distorted = r * model.radial(r**2)[0]
        rising = np.diff(distorted, prepend=0.0) > 0
    ends = np.flatnonzero(~rising | (distorted >= reach))
    end = r[max(int(ends[0]), 1)] if len(ends) else r[-1]
    return np.asarray(np.linspace(0, end, _PROFILE + 1)[1:])
