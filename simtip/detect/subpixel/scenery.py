"""What a tip is fitted to: the pixels around it, and what the shaft's fit says of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.brightness import BLURRED_ROWS, ground_columns
from simtip.detect.subpixel.outline import Family
from simtip.detect.subpixel.picture import Cells, Cover, Placed, Window, cover
from simtip.detect.subpixel.saturated import FULL_SCALE
from simtip.detect.subpixel.shaft import Shaft
from simtip.geometry import Array

SIDE_PX, BELOW_PX = 6, 8

AXIS_DEVIATION_PX, AXIS_SHARE = 0.002, 0.01
"""How far the shaft's axis may be off besides, px, and of the blur's deviation more."""

LOCKED_PX = 0.2
"""How far an edge may be off that a sharp picture shows in one column alone, px."""

BLURRED_WIDTH = 0.3
"""How far the shaft's half width may be off in a blurred picture, px."""

POSE = 5
"""Parameters before the shape: row v of z = 0 on the axis, shift across, half width, variance of
the blur, px^2, lean."""

SHIFT, BLUR, LEAN = 1, 3, 4
"""Which of those are the axis' shift across, the blur, and what is added to the axis' slope."""

BLUR_SHARE, BLUR_DEVIATION_PX2 = 0.25, 0.02
"""How far the shaft's blur may be off, of it, and px^2 more: width and blur are told apart by the
shape of an edge only. A tip has edges across, too."""

SHARP_PX2 = 0.1
"""So sharp, a picture does not change evenly with its blur: of some the best is taken."""

SHARP_BLURS_PX2 = 0.0, 0.015, 0.04, 0.1
"""Those."""


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
    row
        About which the axis leans, and at which the shaft tells where it is.
    axis_precision
        Inverse of the covariance (2, 2) of the axis' u and slope there, by the shaft.
    half_deviation
        Of the shaft's half width there, px.
    variance_px2, variance_deviation
        Of the blur at the tip, by the shaft, px^2.
    level
        Of the background, DN.
    tilt
        Sine of the axis, towards the hub, along the line of sight.
    rim_tilt
        The same for the circle at which the shaft begins; 0, a straight line, where the camera is
        not known.
    left_out
        (H W,) which pixels do not count.
    seamless
        Whether those where the tip meets the shaft are among them.
    clutter
        (H W,) variance, DN^2, of what lies behind the needle and is no even ground.
    """

    window: Window
    value: Array
    shaft: Shaft
    row: float
    axis_precision: Array
    half_deviation: float
    half_px: float
    variance_px2: float
    variance_deviation: float
    level: float
    tilt: float
    rim_tilt: float
    left_out: NDArray[np.bool_]
    clutter: Array | float = 0.0
    seamless: bool = False

    @property
    def sharp(self) -> bool:
        """Whether the blur is one of `SHARP_BLURS_PX2`, and no matter of a fit's steps."""
        return self.variance_px2 < SHARP_PX2

    @property
    def begun_px2(self) -> float:
        """Variance of the blur at which a fit begins."""
        return SHARP_BLURS_PX2[0] if self.sharp else self.variance_px2

    @cached_property
    def ground(self) -> Array:
        """What the background's brightness is made of, (H W, `GROUND_COLUMNS`)."""
        return ground_columns(self.window)

    @cached_property
    def noise(self) -> Array:
        """Variance of each pixel's gray value (H W,) that the camera makes, DN^2."""
        return self.shaft.noise_dn2(self.value)

    @cached_property
    def precision(self) -> Array:
        """Root of each pixel's weight (H W,), 1 / DN: one over the noise's deviation, or 0."""
        counts = 1 / np.sqrt(self.noise + self.clutter)
        return np.where(self.left_out, 0.0, counts)

    @cached_property
    def counted(self) -> int:
        """How many pixels count."""
        return int(len(self.value) - self.left_out.sum())

    def left_dn(self, residual: Array) -> float:
        """Give the root mean square of residuals (H W,) of the pixels that count, DN."""
        return float(np.sqrt(np.sum(residual[~self.left_out] ** 2) / max(self.counted, 1)))

    @cached_property
    def weighted(self) -> tuple[Array, Array]:
        """`ground` (H W, n) and `value` (H W,), weighted."""
        return self.ground * self.precision[:, None], self.value * self.precision

    @cached_property
    def all_ground(self) -> tuple[Array, Array]:
        """Normal equations of the background, were there no needle: (n, n) and (n,)."""
        ground, value = self.weighted
        return ground.T @ ground, ground.T @ value

    def tilted(self, more: float) -> Scenery:
        """Give it with so much more tilt of the axis along the line of sight."""
        return replace(self, tilt=self.tilt + more)

    def points(self, which: NDArray[np.intp]) -> tuple[Array, Array]:
        """Give u and v (n,) of pixels by their flat index."""
        v, u = np.divmod(which, self.window.width)
        return (u + self.window.u).astype(np.float64), (v + self.window.v).astype(np.float64)

    def place(self, family: Family, values: Array) -> Placed:
        """Put an outline into the image."""
        origin, across, hub = self._axes(values)
        v, half = values[0], values[2]
        end = (v - self.window.v + half + 20.0) * 1.5
        outline = family.polygon(half, values[POSE:], end, self.tilt)
        corners = origin + outline[:, :1] * across + outline[:, 1:] * hub
        facet = None
        if family.facet is not None:
            drawn = family.facet(half, values[POSE:], self.tilt)
            facet = origin + drawn[:, :1] * across + drawn[:, 1:] * hub
        return Placed(
            corners, facet, origin, hub, half, family.depth(half, values[POSE:]), self.rim_tilt
        )

    def apex(self, family: Family, values: Array) -> Array:
        """Give u, v of the apex (2,)."""
        origin, across, hub = self._axes(values)
        x, z = family.apex(values[2], values[POSE:], self.tilt)
        return np.asarray(origin + x * across + z * hub)

    def _axes(self, values: Array) -> tuple[Array, Array, Array]:
        """Give the outline's origin u, v, and the unit vectors across it and to its hub."""
        v, lean = float(values[0]), float(values[LEAN])
        u, slope = self.shaft.axis_at(v)
        slope += lean
        hub = np.array([-slope, -1.0]) / np.hypot(1, slope)
        across = np.array([-hub[1], hub[0]])
        return np.array([u + lean * (v - self.row), v]) + values[SHIFT] * across, across, hub

    def cells(self, variance_px2: float) -> Cells:
        """Give the window's cells in a picture so blurred."""
        return Cells(self.window, variance_px2, self.shaft.disc_share)

    def brightness_cells(self, variance_px2: float) -> Cells:
        """Give the window's cells in which a picture so blurred has its brightness."""
        return replace(self.cells(variance_px2), rows_per_px=BLURRED_ROWS)

    def cover(self, placed: Placed, variance_px2: float) -> Cover:
        """Work out what an outline covers in a picture so blurred."""
        return cover(placed, self.cells(variance_px2))


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
    image: NDArray[np.float32],
    shaft: Shaft,
    v_end: float,
    depth: float,
    level: float,
    tilts: tuple[float, float],
) -> Scenery:
    """Gather what a tip is fitted to."""
    variance = float(shaft.variance_px2(np.array(v_end)))
    doubt = BLUR_SHARE * variance + BLUR_DEVIATION_PX2
    half = float(shaft.half_px(np.array(v_end)))
    window = window_about(image.shape, shaft, half, v_end, depth, 3 * np.sqrt(variance))
    part = image[window.v : window.v + window.height, window.u : window.u + window.width]
    axis = shaft.axis_covariance(v_end)
    axis[0, 0] += (AXIS_DEVIATION_PX + AXIS_SHARE * np.sqrt(variance)) ** 2
    locked = _locked_px(shaft, v_end) if variance < SHARP_PX2 else 0.0
    axis[0, 0] += locked**2
    n, m = len(shaft.axis), len(shaft.width)
    wide = float(shaft.t(np.array(v_end))) ** np.arange(m)
    half_deviation = float(np.sqrt(wide @ shaft.covariance[n : n + m, n : n + m] @ wide))
    return Scenery(
        window,
        np.nan_to_num(part.reshape(-1).astype(np.float64), nan=FULL_SCALE),
        shaft,
        v_end,
        np.asarray(np.linalg.inv(axis), np.float64),
        max(half_deviation, 0.01) + locked + BLURRED_WIDTH * variance / (variance + 0.1),
        half,
        variance,
        doubt,
        level,
        *tilts,
        np.isnan(part.reshape(-1)),
    )


def _locked_px(shaft: Shaft, v: float) -> float:
    """Give how far an edge may be off that stays within one column of a sharp picture.

    There only one pixel of a row tells where it is, and as well how bright the rim is.
    """
    crossed = float(abs(shaft.axis_u(np.array(v)) - shaft.axis_u(np.array(v - shaft.scale))))
    return LOCKED_PX * max(0.0, 1 - crossed)
