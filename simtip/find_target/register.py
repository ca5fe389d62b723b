"""Sub-pixel places: the target's own ink, blurred as the image is, laid over each point.

Around each point the print is drawn as the image's geometry shows it (perspective and distortion
included, so a circle's centre is not mistaken for the centre of its ellipse), blurred, and moved to
where it fits best by least squares, together with its brightness, contrast, slopes of both and the
width of the blur. Around a corner and around a circle the drawing is symmetric under a half turn,
so a wrong width or shape of the blur, and any tone curve, moves nothing. B. D. Lucas and T. Kanade,
"An iterative image registration technique", IJCAI 1981, is the kind of fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.find_target.local_map import LocalMap
from simtip.geometry import Array
from simtip.target import Target

Image = NDArray[np.float32]

CORNER_REACH = 0.45
"""Half the side of the patch around a corner, in steps: beyond half a step are other corners."""

SMALLEST_PX, LARGEST_PX, LARGEST_BLURS = 4.0, 18.0, 2.0
"""Bounds of half a patch around a corner; the latter is in px and, added to that, in SDs of the
blur. More costs time and gains little."""

TOO_LARGE_PX = 250.0
"""Half a patch for which there is no time: a circle that large needs a smaller image."""

SAMPLES = 2
"""Samples of the drawing per pixel, each way; the half step of `_Drawing` is for 2."""

EDGE_SAMPLES = 6
"""Samples within one of those, each way, where an edge passes through."""

FEWEST = 25
"""Pixels that a fit needs at least."""

ROUNDS = 8
"""Most steps of the fit."""

STILL_PX = 1e-3
"""The fit ends when it moves less than this."""

LONGEST_MOVE_PX = 2.0
"""Most that one step moves."""

LONGEST_WAY = 0.6
"""Most that all steps move, in half patches."""

BLUR_TOLERANCE = 0.03
"""Change of the blur, of itself, that is worth drawing anew."""

LEAST_BLUR_PX, LARGEST_BLUR = 0.3, 0.15
"""Narrowest blur (SD) that is fitted, px, and widest, in steps of the lattice."""

FIRST_BLUR_PX = 1.0


@dataclass(frozen=True)
class Placed:
    """Where the drawing of one point fits.

    Attributes
    ----------
    pixel
        (2,) u, v.
    blur_px
        SD of the blur that comes on top of the pixel's own area.
    likeness
        Correlation of the drawing and the image, after slopes of brightness: 1 is perfect; below 0
        the image has black and white exchanged.
    """

    pixel: Array
    blur_px: float
    likeness: float


def register(
    target: Target, image: Image, point: int, here: LocalMap, blur_px: float = FIRST_BLUR_PX
) -> Placed | None:
    """Fit the ink around one of the target's points; None if it leads out of the patch.

    Parameters
    ----------
    target
        Whose point it is.
    image
        (H, W) gray.
    point
        Its id.
    here
        Maps the pixels around to the lattice.
    blur_px
        First guess of the blur.
    """
    place = target.lattice[point].astype(np.float64)
    centre = here.pixel(place)
    if not np.isfinite(centre).all():
        return None
    slopes: Array = np.linalg.inv(here.slopes(centre)).astype(np.float64)
    half = _half_sizes(target, slopes, blur_px)
    if half.max() > TOO_LARGE_PX:
        return None
    patch = _Patch(image, centre, half)
    if patch.values.size < FEWEST:
        return None
    region = _region(target, here, place, centre, patch)
    if np.count_nonzero(region) < FEWEST:
        return None
    step_px = float(np.linalg.norm(slopes, axis=0).min())
    most_blur_px = max(LARGEST_BLUR * step_px, 2 * LEAST_BLUR_PX)
    drawing = _Drawing(target, here, centre, half, min(blur_px, most_blur_px))
    return _fitted(drawing, patch, region, centre, most_blur_px)


def _half_sizes(target: Target, slopes: Array, blur_px: float) -> Array:
    """Give half the patch's width and height, px; `slopes` are of pixels by the lattice."""
    if target.disc_radius is None:
        most = LARGEST_PX + LARGEST_BLURS * blur_px
        return np.asarray(np.clip(CORNER_REACH * np.abs(slopes).sum(axis=1), SMALLEST_PX, most))
    box = target.disc_radius * np.linalg.norm(slopes, axis=1) + 2.5 * blur_px + 1.5
    return np.asarray(np.maximum(box, SMALLEST_PX))


class _Patch:
    """A rectangle of the image: `first` its corner (u, v), `values` (rows, columns)."""

    def __init__(self, image: Image, centre: Array, half: Array) -> None:
        h, w = image.shape
        low = np.maximum(np.ceil(centre - half), 0).astype(np.intp)
        high = np.minimum(np.floor(centre + half) + 1, [w, h]).astype(np.intp)
        high = np.maximum(low, high)
        self.first = low
        self.values = image[low[1] : high[1], low[0] : high[0]].astype(np.float64)

    def pixels(self) -> Array:
        """Give (m, 2) u, v, row by row."""
        rows, columns = self.values.shape
        u, v = np.arange(columns) + self.first[0], np.arange(rows) + self.first[1]
        return np.column_stack([np.tile(u, rows), np.repeat(v, columns)]).astype(np.float64)


def _region(
    target: Target, here: LocalMap, place: Array, centre: Array, patch: _Patch
) -> NDArray[np.bool_]:
    """Say which pixels of a patch belong to the point rather than to its neighbours."""
    if target.disc_radius is not None:
        return np.ones(patch.values.size, dtype=np.bool_)
    pixels = patch.pixels()
    inside = (np.abs(here.lattice(pixels) - place) <= CORNER_REACH).all(axis=1)
    return np.asarray(inside | (np.abs(pixels - centre).max(axis=1) <= SMALLEST_PX))


class _Drawing:
    """The ink around a point on a fine grid whose middle is the point, blurred on demand."""

    def __init__(
        self, target: Target, here: LocalMap, centre: Array, half: Array, blur_px: float
    ) -> None:
        n = np.ceil((half + 2.5 * blur_px + 4) * SAMPLES).astype(np.intp)
        # Samples lie half a step off the middle, so their errors are alike on both sides of it.
        u = (np.arange(2 * n[0]) - n[0] + 0.5) / SAMPLES
        v = (np.arange(2 * n[1]) - n[1] + 0.5) / SAMPLES
        offsets = np.column_stack([np.tile(u, len(v)), np.repeat(v, len(u))])

        def ink(at: Array) -> Array:
            return target.ink(here.lattice(centre + at) * target.pitch_mm)

        sharp = ink(offsets).reshape(len(v), len(u)).astype(np.float32)
        square = np.ones((3, 3), np.uint8)
        edges = np.flatnonzero(cv2.dilate(sharp, square) != cv2.erode(sharp, square))
        s = ((np.arange(EDGE_SAMPLES) + 0.5) / EDGE_SAMPLES - 0.5) / SAMPLES
        within = np.column_stack([np.tile(s, EDGE_SAMPLES), np.repeat(s, EDGE_SAMPLES)])
        finer = ink((offsets[edges, None] + within).reshape(-1, 2))
        sharp.ravel()[edges] = finer.reshape(len(edges), -1).mean(axis=1)
        # A sample is the mean over its own square; over 2 x 2 of them, over a pixel's. The mean
        # stands half a step on, where the middle of the grid is a sample.
        self.n, self.area = n, cv2.blur(sharp, (SAMPLES, SAMPLES), anchor=(0, 0))
        self.blur(blur_px)

    def blur(self, blur_px: float) -> None:
        """Blur anew."""
        self.blur_px = blur_px
        soft = cv2.GaussianBlur(self.area, (0, 0), blur_px * SAMPLES)
        # The heat equation: a wider blur adds its SD times the Laplacian.
        wider = cv2.Laplacian(soft, cv2.CV_32F) * np.float32(blur_px * SAMPLES**2)
        self.layers = np.stack([soft, wider]).astype(np.float64)

    def at(self, patch: _Patch, centre: Array) -> Array | None:
        """Sample (4, m) value, change with blur, slopes by u and v; None if out of the grid."""
        place = (patch.first - centre) * SAMPLES + self.n - 1.0
        base = np.floor(place).astype(np.intp)
        rows, columns = patch.values.shape
        end = base + SAMPLES * (np.array([columns, rows]) - 1) + 2
        if (base < 1).any() or (end >= 2 * self.n).any():
            return None
        # All pixels lie at the same fraction of a step: the weights are few numbers.
        (wu, su), (wv, sv) = (_cubic(float(f)) for f in place - base)
        across = np.zeros((3, *self.layers.shape[1:2], columns))
        for a in range(4):
            first = base[0] + a - 1
            columns_a = self.layers[:, :, first : first + SAMPLES * (columns - 1) + 1 : SAMPLES]
            across[:2] += wu[a] * columns_a
            across[2] += SAMPLES * su[a] * columns_a[0]
        result = np.zeros((4, rows, columns))
        for b in range(4):
            first = base[1] + b - 1
            rows_b = across[:, first : first + SAMPLES * (rows - 1) + 1 : SAMPLES]
            result[:3] += wv[b] * rows_b
            result[3] += SAMPLES * sv[b] * rows_b[0]
        return result.reshape(4, -1)


def _cubic(t: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Weights of four samples at -1, 0, 1, 2 for the cubic's value at t, and for its slope."""
    value = (
        -t * (t - 1) * (t - 2) / 6,
        (t + 1) * (t - 1) * (t - 2) / 2,
        -(t + 1) * t * (t - 2) / 2,
        (t + 1) * t * (t - 1) / 6,
    )
    slope = (
        -(3 * t * t - 6 * t + 2) / 6,
        (3 * t * t - 4 * t - 1) / 2,
        -(3 * t * t - 2 * t - 2) / 2,
        (3 * t * t - 1) / 6,
    )
    return value, slope


def _fitted(
    drawing: _Drawing,
    patch: _Patch,
    region: NDArray[np.bool_],
    start: Array,
    most_blur_px: float,
) -> Placed | None:
    """Move, blur and scale the drawing until it fits."""
    centre, found = start, None
    values = patch.values.ravel()[region]
    size = max(patch.values.shape) / 2
    d = (patch.pixels()[region] - start) / size
    flat = np.column_stack([np.ones(len(d)), d])
    for _ in range(ROUNDS):
        layers = drawing.at(patch, centre)
        if layers is None:
            return None
        soft, wider, du, dv = layers[:, region]
        columns = np.column_stack([flat, d * soft[:, None], soft, du, dv, wider])
        x = _least_squares(columns, values)
        if x is None or x[5] == 0:
            return None
        move = -x[6:8] / x[5]
        length = float(np.hypot(*move))
        centre = centre + move * min(1.0, LONGEST_MOVE_PX / max(length, 1e-12))
        if np.abs(centre - start).max() > LONGEST_WAY * size:
            return None
        blur_px = drawing.blur_px * float(np.clip(1 + x[8] / x[5] / drawing.blur_px, 0.6, 1.6))
        blur_px = float(np.clip(blur_px, LEAST_BLUR_PX, most_blur_px))
        found = Placed(centre, blur_px, _likeness(flat, soft, values))
        settled = abs(blur_px - drawing.blur_px) < BLUR_TOLERANCE * drawing.blur_px
        if length < STILL_PX and settled:
            break
        if not settled:
            drawing.blur(blur_px)
    return found


def _least_squares(columns: Array, values: Array) -> Array | None:
    normal = columns.T @ columns
    scale = np.sqrt(np.diag(normal))
    if not (scale > 0).all():
        return None
    normal = normal / np.outer(scale, scale) + 1e-9 * np.eye(len(scale))
    x: Array = np.linalg.solve(normal, columns.T @ values / scale) / scale
    return x if np.isfinite(x).all() else None


def _likeness(flat: Array, soft: Array, values: Array) -> float:
    """Correlate ink and darkness after taking a plane of brightness out of both."""
    both = np.column_stack([soft, values])
    rest = both - flat @ np.linalg.solve(flat.T @ flat, flat.T @ both)
    norms = np.linalg.norm(rest, axis=0)
    if not (norms > 1e-9).all():
        return 0.0
    return float(-(rest[:, 0] @ rest[:, 1]) / norms.prod())
