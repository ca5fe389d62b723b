"""Camera and stereo rig: the geometry that the simulation and the measurement share.

Camera frame: x right, y down, z forward, mm. A pixel is (u, v), u to the right and v down;
(0, 0) is the centre of the top-left pixel, as in OpenCV.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array, Pose, skew

ROUND_TRIP_PX = 1e-3
"""How far a pixel may be from the projection of its own ray."""

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
            # OpenCV says nothing when its iteration fails.
            back = self.project(np.column_stack([xy, np.ones(len(xy))]))
            xy[~(np.abs(back - flat).max(axis=1) <= ROUND_TRIP_PX)] = np.nan
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

    Outwards from the centre, in all directions, the projection has to keep its orientation until it
    has left the image; where it turns back before, two rays share a pixel or pixels have no ray.
    """
    if not camera.distortion:
        return False
    angle = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    radius = np.geomspace(1e-3, 10, 400)
    xy = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    points = np.concatenate([xy, np.ones((*xy.shape[:-1], 1))], axis=-1)
    pixels = camera.project(points)
    step = 1e-5
    du = (camera.project(points + np.array([step, 0, 0])) - pixels) / step
    dv = (camera.project(points + np.array([0, step, 0])) - pixels) / step
    upright = du[..., 0] * dv[..., 1] - du[..., 1] * dv[..., 0] > 0
    outside = ~camera.contains(pixels)
    # All that lies before the first point outside has to be upright, and there has to be one.
    before = np.cumsum(outside, axis=0) == 0
    return bool((before & ~upright).any() or not outside.any(axis=0).all())


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
