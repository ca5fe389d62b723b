"""Two image points and a calibrated rig to one point in space (paper section 3.4).

With distortion undone, a left point has the viewing direction d_1 = (x_1/f_1, y_1/f_1, 1) in the
left frame, and a right point d_2 = R (x_2/f_2, y_2/f_2, 1), turned into the left frame. Points on
the rays are ``z_1 d_1`` and ``z_2 d_2 + T`` (Eq. 18 and 19, ``P_1 = R P_2 + T``), with z_1 and z_2
the depths in the two cameras.

Three methods, the same for exact input:

``svd``
    The paper's. Eq. 21 divided by z_2 is linear in two unknowns::

        [d_1  T] [z_1/z_2, -1/z_2]^T = d_2

    (Eq. 22, with y_2 beside r_i2 where the text repeats x_2), three equations solved by least
    squares with the singular value decomposition. Its residual is the gap between the rays at
    depths z_1 and z_2, divided by z_2. The paper does not say which point it reports when the rays
    miss each other; here it is the one on the left ray, ``z_1 d_1``.
``midpoint``
    Halfway between the points where the rays come closest.
``optimal``
    Least sum of squared distances, over both images, between the undistorted points and the
    projections of the point: the maximum-likelihood point for equal, isotropic pixel noise. The
    global minimum, by the polynomial of Hartley and Sturm, "Triangulation", CVIU 68 (1997).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from simtip.camera import StereoRig
from simtip.correspondence import nearest_correspondence
from simtip.geometry import Array, unit

Method: TypeAlias = Literal["svd", "midpoint", "optimal"]
METHODS: tuple[Method, ...] = get_args(Method)

PARALLEL_TOLERANCE_RAD = 1e-9
"""Rays within this angle count as parallel: 72 mm apart, they would meet 72,000 km away."""

STEP_PX = 1e-2
"""Step of the central differences for the covariance: the error of order step^2 is below 1e-8."""


class TriangulationStatus(StrEnum):
    """Machine-readable outcome of a triangulation."""

    OK = "ok"
    RAYS_PARALLEL = "rays_parallel"
    ALONG_BASELINE = "along_baseline"
    BEHIND_CAMERA = "behind_camera"


@dataclass(frozen=True, eq=False)
class TipEstimate:
    """The tip in space, or the reason why there is none.

    Attributes
    ----------
    status
        ``ok``, or the code of the reason.
    reason
        One sentence with the numbers; empty when there is a point.
    method
        Which method was used.
    point_mm
        (3,) in the rig (left camera) frame, mm, or None.
    covariance_mm2
        (3, 3) mm^2, first order, from the pixel covariances; None if these were not given.
    gap_mm
        Shortest distance between the two rays, mm, the same for every method.
    depths_mm
        (2,) z of the point in the left and in the right camera, mm.
    reprojection_px
        (2, 2), rows left and right: given tip - projection of the point (u, v), px of the images
        as they are.
    """

    status: TriangulationStatus
    reason: str
    method: Method
    point_mm: Array | None = None
    covariance_mm2: Array | None = None
    gap_mm: float | None = None
    depths_mm: Array | None = None
    reprojection_px: Array | None = None

    @property
    def ok(self) -> bool:
        """Whether there is a point."""
        return self.status is TriangulationStatus.OK


def triangulate(
    tip_left_px: ArrayLike,
    tip_right_px: ArrayLike,
    rig: StereoRig,
    method: Method = "svd",
    *,
    covariance_left_px: ArrayLike | None = None,
    covariance_right_px: ArrayLike | None = None,
    sigma_px: float | None = None,
) -> TipEstimate:
    """Triangulate one pair of tips.

    Parameters
    ----------
    tip_left_px, tip_right_px
        (2,) u, v in px of the images as they are.
    rig
        The calibrated cameras.
    method
        ``svd``, ``midpoint`` or ``optimal``; see the module.
    covariance_left_px, covariance_right_px
        (2, 2) px^2 of each tip; the two are taken as independent.
    sigma_px
        Standard deviation per coordinate, px, for a view without a covariance of its own.

    Returns
    -------
    TipEstimate
        With a covariance if both views have one, or a `sigma_px`.

    Raises
    ------
    ValueError
        A tip is not two finite numbers, a covariance is not (2, 2) and finite, or the method is
        unknown.
    """
    pair = np.stack([_tip(tip_left_px), _tip(tip_right_px)])
    _require_method(method)
    d1, d2 = _directions(pair[0], pair[1], rig)
    failure = _degenerate(d1, d2, rig.T_lr.t)
    if failure:
        return TipEstimate(*failure, method)
    point = triangulate_points(pair[0], pair[1], rig, method)
    depths = np.array([point[2], rig.T_lr.inverse().apply(point)[2]])
    # diverging rays come closest behind the cameras, whatever point a method makes of them
    nearest = np.stack(_closest_depths(d1, d2, rig.T_lr.t))
    if min(*depths, *nearest) <= 0:
        return TipEstimate(TriangulationStatus.BEHIND_CAMERA, _behind(depths, nearest), method)
    noise = _noise(covariance_left_px, covariance_right_px, sigma_px)
    return TipEstimate(
        TriangulationStatus.OK,
        "",
        method,
        point_mm=point,
        covariance_mm2=None if noise is None else _propagated(pair, rig, method, noise),
        gap_mm=_gap(d1, d2, rig.T_lr.t),
        depths_mm=depths,
        reprojection_px=pair - np.stack(rig.project(point)),
    )


def _require_method(method: str) -> None:
    if method not in METHODS:
        raise ValueError(f"the method is one of {', '.join(METHODS)}, not {method!r}")


def triangulate_points(
    left_px: ArrayLike, right_px: ArrayLike, rig: StereoRig, method: Method = "svd"
) -> Array:
    """Triangulate many pairs, without checks, covariances or reasons.

    Parameters
    ----------
    left_px, right_px
        (..., 2) paired points, px of the images as they are.
    rig
        The calibrated cameras.
    method
        ``svd``, ``midpoint`` or ``optimal``; see the module.

    Returns
    -------
    Array
        (..., 3) mm, rig frame. Meaningless or not finite where rays are parallel or lie on the
        baseline; behind the cameras where rays diverge. `triangulate` tells these apart.
    """
    _require_method(method)
    left, right = np.asarray(left_px, dtype=np.float64), np.asarray(right_px, dtype=np.float64)
    d1, d2 = _directions(left, right, rig)
    if method == "svd":
        return _svd_point(d1, d2, rig.T_lr.t)
    if method == "midpoint":
        return _midpoint(d1, d2, rig.T_lr.t)
    left, right = rig.left.undistort(left), rig.right.undistort(right)
    F = rig.fundamental()
    corrected = [
        nearest_correspondence(a, b, F)
        for a, b in zip(left.reshape(-1, 2), right.reshape(-1, 2), strict=True)
    ]
    a, b = np.moveaxis(np.reshape(corrected, (*left.shape[:-1], 2, 2)), -2, 0)
    pinholes = replace(
        rig, left=replace(rig.left, distortion=()), right=replace(rig.right, distortion=())
    )
    # These rays meet, so that any method gives their point.
    return _midpoint(*_directions(a, b, pinholes), rig.T_lr.t)


def _tip(tip_px: ArrayLike) -> Array:
    tip = np.asarray(tip_px, dtype=np.float64)
    if tip.shape != (2,) or not np.isfinite(tip).all():
        raise ValueError("a tip is two finite numbers, u and v")
    return tip


def _directions(left_px: Array, right_px: Array, rig: StereoRig) -> tuple[Array, Array]:
    """Give d_1 and d_2 (..., 3) in the left frame, each with z = 1 in its own camera."""
    d1 = _with_one(rig.left.normalise(left_px))
    return d1, rig.T_lr.rotate(_with_one(rig.right.normalise(right_px)))


def _with_one(xy: Array) -> Array:
    return np.concatenate([xy, np.ones((*xy.shape[:-1], 1))], axis=-1)


def _svd_point(d1: Array, d2: Array, t: Array) -> Array:
    # A column's scale does not change a least-squares solution; a unit T conditions it better.
    baseline = np.linalg.norm(t)
    A = np.stack([d1, np.broadcast_to(t / baseline, d1.shape)], axis=-1)
    unknowns = (np.linalg.pinv(A) @ d2[..., None])[..., 0]
    z2 = -baseline / unknowns[..., 1]
    z1 = unknowns[..., 0] * z2
    return z1[..., None] * d1


def _midpoint(d1: Array, d2: Array, t: Array) -> Array:
    z1, z2 = _closest_depths(d1, d2, t)
    return (z1[..., None] * d1 + z2[..., None] * d2 + t) / 2


def _closest_depths(d1: Array, d2: Array, t: Array) -> tuple[Array, Array]:
    """Give the depths, each in its own camera, where the two rays come closest."""
    # z_1 d_1 - z_2 d_2 = T + c n, with n = d_1 x d_2; cross with d_2 or d_1, then dot with n.
    n = np.cross(d1, d2)
    square = (n * n).sum(axis=-1)
    z1: Array = (np.cross(t, d2) * n).sum(axis=-1) / square
    z2: Array = (np.cross(t, d1) * n).sum(axis=-1) / square
    return z1, z2


def _gap(d1: Array, d2: Array, t: Array) -> float:
    n = np.cross(d1, d2)
    return float(abs(t @ n) / np.linalg.norm(n))


def _degenerate(d1: Array, d2: Array, t: Array) -> tuple[TriangulationStatus, str] | None:
    """Say why two rays have no point of meeting, if so."""
    angle = _angle(d1, d2)
    if angle < PARALLEL_TOLERANCE_RAD:
        reason = f"the rays are parallel: the angle between them is {angle:.2g} rad"
        return TriangulationStatus.RAYS_PARALLEL, reason
    if min(_angle(d1, t), _angle(d2, t)) < PARALLEL_TOLERANCE_RAD:
        reason = "a ray runs along the line through both cameras"
        return TriangulationStatus.ALONG_BASELINE, reason
    return None


def _angle(a: Array, b: Array) -> float:
    """Give the sine of the angle between two lines: the angle itself, rad, where it matters."""
    return float(np.linalg.norm(np.cross(unit(a), unit(b))))


def _behind(depths: Array, nearest: Array) -> str:
    if min(depths) <= 0:
        return (
            f"the point is not in front of both cameras: its depth is {depths[0]:.4g} mm in the "
            f"left and {depths[1]:.4g} mm in the right"
        )
    return (
        f"the rays come closest behind a camera: at a depth of {nearest[0]:.4g} mm in the left "
        f"and {nearest[1]:.4g} mm in the right"
    )


def _noise(left: ArrayLike | None, right: ArrayLike | None, sigma_px: float | None) -> Array | None:
    """Give the (4, 4) covariance of u_l, v_l, u_r, v_r, px^2, or None if a view has none."""
    noise = np.zeros((4, 4))
    for given, view in ((left, slice(0, 2)), (right, slice(2, 4))):
        if given is not None:
            covariance = np.asarray(given, dtype=np.float64)
        elif sigma_px is not None:
            covariance = sigma_px**2 * np.eye(2)
        else:
            return None
        if covariance.shape != (2, 2) or not np.isfinite(covariance).all():
            raise ValueError("a tip covariance is 2 x 2 finite numbers")
        noise[view, view] = covariance
    return noise


def _propagated(pair: Array, rig: StereoRig, method: Method, noise: Array) -> Array:
    """Carry pixel noise (4, 4) to first order into the point: J noise J^T, mm^2."""
    steps = STEP_PX * np.eye(4).reshape(4, 2, 2)
    ahead, back = (
        triangulate_points(moved[:, 0], moved[:, 1], rig, method)
        for moved in (pair + steps, pair - steps)
    )
    J = (ahead - back).T / (2 * STEP_PX)
    covariance: Array = J @ noise @ J.T
    return (covariance + covariance.T) / 2
