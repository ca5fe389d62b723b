"""Camera and stereo rig: the geometry that the simulation and the measurement share.

Camera frame: x right, y down, z forward, mm. A pixel is (u, v), u to the right and v down;
(0, 0) is the centre of the top-left pixel, as in OpenCV.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from simtip.geometry import Array, Pose, skew

ROUND_TRIP_PX = 1e-3
"""How far a pixel may be from the projection of its own ray."""

GOOD_PX = 1e-4
"""How near a stage on the way to a pixel has to come; the last one goes on to rounding."""

STAGES, NEWTON_STEPS = (16, 96), 10
"""Stages from the centre of distortion to a pixel, more if few fail, and Newton steps in each."""

BORDER_STEPS, RADIAL_STEPS = 128, 64
"""Places along the image's shorter side, and from the centre to each, where folds are sought."""

BLOCK = 65536
"""Pixels worked on at a time."""

DISTORTION_LENGTHS = (0, 4, 5, 8, 12, 14)


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera with OpenCV's distortion model (paper Eq. 9, plus distortion).

    Attributes
    ----------
    K
        (3, 3) intrinsic matrix ``[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]``, px.
    width, height
        Image size, px.
    distortion
        OpenCV's coefficients ``k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]]``, or empty.
    """

    K: Array
    width: int
    height: int
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        K = np.array(self.K, dtype=np.float64)
        if K.shape != (3, 3) or not np.isfinite(K).all():
            raise ValueError("the intrinsic matrix is not 3 x 3 finite numbers")
        fx, fy = K[0, 0], K[1, 1]
        if fx <= 0 or fy <= 0:
            raise ValueError(f"the focal lengths have to be above 0 px, not {fx:g} and {fy:g}")
        expected = np.array([[fx, 0, K[0, 2]], [0, fy, K[1, 2]], [0, 0, 1]])
        if not np.array_equal(K, expected):
            raise ValueError("the intrinsic matrix is not [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
        if self.width < 1 or self.height < 1:
            raise ValueError(f"the image size has to be positive, not {self.width}x{self.height}")
        distortion = tuple(float(c) for c in np.ravel(self.distortion))
        if len(distortion) not in DISTORTION_LENGTHS or not np.isfinite(distortion).all():
            raise ValueError(
                f"distortion takes {DISTORTION_LENGTHS} finite coefficients, not {len(distortion)}"
            )
        K.setflags(write=False)
        object.__setattr__(self, "K", K)
        object.__setattr__(self, "distortion", distortion if any(distortion) else ())

    @property
    def size(self) -> tuple[int, int]:
        """(width, height), px."""
        return self.width, self.height

    def cropped(self, x: int, y: int, width: int, height: int) -> Camera:
        """Return the camera that reads out only a region of interest: same rays, new pixels."""
        K = self.K.copy()
        K[0, 2] -= x
        K[1, 2] -= y
        return replace(self, K=K, width=width, height=height)

    def project(self, points: ArrayLike) -> Array:
        """Project camera-frame points (..., 3), mm, to pixels (..., 2); NaN at or behind z = 0."""
        p = np.asarray(points, dtype=np.float64)
        flat = p.reshape(-1, 3)
        pixels = np.full((len(flat), 2), np.nan)
        front = flat[:, 2] > 0
        if front.any():
            if self.distortion:
                projected, _ = cv2.projectPoints(
                    flat[front].reshape(-1, 1, 3),
                    np.zeros(3),
                    np.zeros(3),
                    self.K,
                    np.asarray(self.distortion),
                )
                pixels[front] = projected.reshape(-1, 2)
            else:
                xy = flat[front, :2] / flat[front, 2:]
                pixels[front] = xy * [self.K[0, 0], self.K[1, 1]] + self.K[:2, 2]
        return pixels.reshape(*p.shape[:-1], 2)

    def normalise(self, pixels: ArrayLike) -> Array:
        """Undo intrinsics and distortion: pixels (..., 2) to (x/z, y/z) (..., 2).

        NaN where the distortion model has no ray for the pixel, or none was found.
        """
        uv = np.asarray(pixels, dtype=np.float64)
        flat = uv.reshape(-1, 2)
        if self.distortion and len(flat):
            criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-13)
            xy = cv2.undistortPoints(
                flat.reshape(-1, 1, 2),
                self.K,
                np.asarray(self.distortion),
                criteria=criteria,
            ).reshape(-1, 2)
            # OpenCV says nothing when its iteration fails, as it does for strong distortion.
            back = self.project(np.column_stack([xy, np.ones(len(xy))]))
            failed = ~(np.abs(back - flat).max(axis=1) <= ROUND_TRIP_PX)
            xy[failed] = _followed(self, flat[failed])
        else:
            xy = (flat - self.K[:2, 2]) / [self.K[0, 0], self.K[1, 1]]
        return np.asarray(xy, dtype=np.float64).reshape(uv.shape)

    def rays(self, pixels: ArrayLike) -> Array:
        """Give unit viewing directions (..., 3) in the camera frame through pixels (..., 2)."""
        xy = self.normalise(pixels)
        d = np.concatenate([xy, np.ones((*xy.shape[:-1], 1))], axis=-1)
        directions: Array = d / np.linalg.norm(d, axis=-1, keepdims=True)
        return directions

    def undistort(self, pixels: ArrayLike) -> Array:
        """Move pixels (..., 2) to where the same rays meet the image without distortion."""
        moved: Array = self.normalise(pixels) * [self.K[0, 0], self.K[1, 1]] + self.K[:2, 2]
        return moved

    def contains(self, pixels: ArrayLike) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Say which pixels (..., 2) lie on the image, whose edge is half a pixel out."""
        uv = np.asarray(pixels, dtype=np.float64)
        with np.errstate(invalid="ignore"):
            inside = (uv >= -0.5) & (uv < np.array(self.size) - 0.5)
        return np.asarray(inside.all(axis=-1))


def folds(camera: Camera) -> bool:
    """Say whether the distortion model leaves its valid region inside the image.

    From the centre of distortion out to the border (half a pixel beyond the outermost centres, the
    exact corners among it), the projection has to keep its orientation and the rational model its
    sign. Otherwise two rays share a pixel or pixels have no ray.
    """
    if not camera.distortion:
        return False
    rays = _followed(camera, border(camera, max(1.0, min(camera.size) / BORDER_STEPS)))
    if np.isnan(rays).any():
        return True
    fraction = np.linspace(0, 1, RADIAL_STEPS + 1)
    _, slopes = _projected(camera, (fraction[:, None, None] * rays).reshape(-1, 2))
    return bool((_determinant(slopes) <= 0).any()) or _turns_back(camera, rays)


def border(camera: Camera, spacing_px: float) -> Array:
    """Give pixels (n, 2) along the image's outer edge, corners included."""
    w, h = camera.size
    u = np.linspace(-0.5, w - 0.5, int(np.ceil(w / spacing_px)) + 1)
    v = np.linspace(-0.5, h - 0.5, int(np.ceil(h / spacing_px)) + 1)
    sides = [np.column_stack([u, np.full_like(u, y)]) for y in (v[0], v[-1])]
    sides += [np.column_stack([np.full_like(v, x), v]) for x in (u[0], u[-1])]
    return np.concatenate(sides)


def _turns_back(camera: Camera, rays: Array) -> bool:
    """Look for poles, and for turning points of the radial part, however narrow they are."""
    k1, k2, _, _, k3, k4, k5, k6 = (*camera.distortion, 0.0, 0.0, 0.0, 0.0)[:8]
    end = float((rays**2).sum(axis=1).max())
    over, under, q = Polynomial([1, k1, k2, k3]), Polynomial([1, k4, k5, k6]), Polynomial([0, 1])
    if not _positive(under, end):
        return True
    if any(camera.distortion[2:4]) or any(camera.distortion[8:]):
        return False  # then the radial part alone decides nothing
    # d/dr of r over(r^2) / under(r^2), times under^2.
    return not _positive(over * under + 2 * q * (over.deriv() * under - over * under.deriv()), end)


def _positive(polynomial: Polynomial, end: float) -> bool:
    """Tell whether a polynomial is above 0 all the way from 0 to `end`."""
    turns = np.real(np.asarray(polynomial.deriv().trim().roots(), dtype=np.complex128))
    where = np.array([0.0, end, *turns[(turns > 0) & (turns < end)]])
    return bool((polynomial(where) > 0).all())


def _followed(camera: Camera, pixels: Array) -> Array:
    """Find the rays of pixels (n, 2) by following each from the centre of distortion outwards.

    Newton's method in stages, so that it stays on the branch that the centre lies on: NaN where
    that ends, at a fold or a pole, before the pixel is reached.
    """
    found = np.full_like(pixels, np.nan)
    for first in range(0, len(pixels), BLOCK):
        part = first + np.flatnonzero(np.isfinite(pixels[first : first + BLOCK]).all(axis=1))
        for stages in STAGES:
            found[part] = _followed_in(stages, camera, pixels[part])
            part = part[np.isnan(found[part]).any(axis=1)]
    return found


def _followed_in(stages: int, camera: Camera, pixels: Array) -> Array:
    found, part = np.full_like(pixels, np.nan), np.arange(len(pixels))
    centre = camera.project([0.0, 0.0, 1.0])
    away, xy = pixels - centre, np.zeros_like(pixels)
    with np.errstate(all="ignore"):
        for stage in range(1, stages + 1):
            wanted = centre + away * (stage / stages)
            xy, kept = _solved(camera, xy, wanted, GOOD_PX if stage < stages else 0.0)
            part, away, xy = part[kept], away[kept], xy[kept]
    found[part] = xy
    return found


def _solved(
    camera: Camera, xy: Array, wanted: Array, enough_px: float
) -> tuple[Array, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]:
    """Move rays (n, 2) to the pixels wanted by Newton's method, and say which arrived upright."""
    for _ in range(NEWTON_STEPS):
        pixels, slopes = _projected(camera, xy)
        u, v = (wanted - pixels).T
        off = np.maximum(np.abs(u), np.abs(v))
        if (off <= enough_px).all():
            break
        a, b, c, d = slopes[:, 0, 0], slopes[:, 0, 1], slopes[:, 1, 0], slopes[:, 1, 1]
        xy = xy + np.column_stack([d * u - b * v, a * v - c * u]) / (a * d - b * c)[:, None]
    pixels, slopes = _projected(camera, xy)
    arrived = np.abs(pixels - wanted).max(axis=1, initial=0) <= ROUND_TRIP_PX
    return xy, arrived & (_determinant(slopes) > 0)


def _projected(camera: Camera, xy: Array) -> tuple[Array, Array]:
    """Give the pixels (n, 2) of rays (x/z, y/z), and their derivatives (n, 2, 2) by x/z, y/z."""
    if not len(xy):
        return np.zeros((0, 2)), np.zeros((0, 2, 2))
    points = np.column_stack([xy, np.ones(len(xy))]).reshape(-1, 1, 3)
    none = np.zeros(3)
    pixels, slopes = cv2.projectPoints(points, none, none, camera.K, np.asarray(camera.distortion))
    # Columns: 3 of the rotation, then 3 of the translation, which at z = 1 moves x/z and y/z.
    columns = np.array(slopes[:, 3:5], dtype=np.float64)
    return np.asarray(pixels, dtype=np.float64).reshape(-1, 2), columns.reshape(-1, 2, 2)


def _determinant(slopes: Array) -> Array:
    """Give the determinants of (n, 2, 2); what is not finite is -1, for upright it is not."""
    det: Array = slopes[:, 0, 0] * slopes[:, 1, 1] - slopes[:, 0, 1] * slopes[:, 1, 0]
    return np.where(np.isfinite(det), det, -1.0)


@dataclass(frozen=True, eq=False)
class StereoRig:
    """Two cameras; the rig's frame is the left camera's.

    Attributes
    ----------
    left, right
        The cameras.
    T_lr
        Maps right-camera coordinates to left-camera coordinates: the paper's Eq. 19,
        ``P_c1 = R P_c2 + T``. OpenCV's stereoCalibrate gives the inverse.
    """

    left: Camera
    right: Camera
    T_lr: Pose

    def fundamental(self) -> Array:
        """Give F (3, 3), unit Frobenius norm, in the paper's order: ``p_l^T F p_r = 0`` (Eq. 12).

        p are homogeneous undistorted pixels. OpenCV's F is the transpose.
        """
        essential = skew(self.T_lr.t) @ self.T_lr.R
        F = np.linalg.inv(self.left.K).T @ essential @ np.linalg.inv(self.right.K)
        scaled: Array = F / np.linalg.norm(F)
        return scaled

    def project(self, points: ArrayLike) -> tuple[Array, Array]:
        """Project rig-frame points (..., 3), mm, into the left and the right image."""
        return self.left.project(points), self.right.project(self.T_lr.inverse().apply(points))
