"""A needle's place in the rig's frame, and small changes of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.detect.subpixel.analysis import Analysis
from simtip.detect.subpixel.sight import tilt_deviation
from simtip.geometry import Array, Pose, skew, unit

SLANT_ROWS = 0.5
"""Of the shaft's rows: how far up its second point is taken."""

PLANE_RAD, TILT_SLACK = 2e-4, 0.02
"""How far a plane of an axis may be turned, rad; and a tilt off besides, which the blur's change
along the shaft makes."""

AXIS_STEPS = 5

ALONG = 0.02
"""How well a tip is told across its axis, of how well along it."""

PARALLEL = 1e-3
"""Two rays at so small an angle, about, meet nowhere."""


def turn(vector: Array) -> Array:
    """Give the rotation (3, 3) about a vector (3,) by its length, rad (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0:
        return np.eye(3)
    K = skew(vector / angle)
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K)


def moved(T_wn: Pose, apex: Array, step: Array) -> Pose:
    """Move a needle.

    Parameters
    ----------
    T_wn
        Its place.
    apex
        (3,) mm, needle frame.
    step
        (6,) move of the apex, mm, rig frame; turn about the apex, rad, needle frame.
    """
    R = T_wn.R @ turn(step[3:])
    return Pose(R, T_wn.apply(apex) + step[:3] - R @ apex)


def rolled(T_wn: Pose, angle: float) -> Pose:
    """Turn a needle about its axis, rad."""
    return Pose(T_wn.R @ turn(np.array([0.0, 0.0, angle])), T_wn.t)


def roll_deg(T_wn: Pose) -> float:
    """Give the roll as scenes count it: 0 where the needle's x is the rig's +x less its part along.

    Within 0.6 degrees of the rig's x axis the rig's z takes the place of x.
    """
    z = T_wn.R[:, 2]
    reference = np.array([1.0, 0, 0]) if abs(z[0]) < np.cos(0.01) else np.array([0, 0, 1.0])
    x0 = unit(reference - (reference @ z) * z)
    x = T_wn.R[:, 0]
    return float(np.degrees(np.arctan2(x @ np.cross(z, x0), x @ x0)))


def first_place(left: Analysis, right: Analysis, rig: StereoRig) -> Pose | None:
    """Put a needle where both pictures see it, its roll unknown.

    Each picture's axis and the camera's centre span a plane that the axis lies in. Where the planes
    are nearly parallel, as of a needle along the rig's baseline, the rays to both tips decide where
    it is, and the tilts along the lines of sight, which the width tells, how it stands.

    None if the needle would be behind a camera, or the rays are parallel.
    """
    sights = [
        _Sight.of(seen, camera, T_wc)
        for seen, camera, T_wc in (
            (left, rig.left, Pose.identity()),
            (right, rig.right, rig.T_lr),
        )
    ]
    tip = _tip(sights)
    if tip is None or tip[2] <= 0 or rig.T_lr.inverse().apply(tip)[2] <= 0:
        return None
    axis = _axis(sights)
    x = unit(np.cross(axis, [0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0.0, 0.0]))
    return Pose(np.stack([x, np.cross(axis, x), axis], axis=1), tip)


@dataclass(frozen=True, eq=False)
class _Sight:
    """What one picture says of the axis, rig frame.

    Attributes
    ----------
    centre, ray
        (3,) the camera's centre, and the direction to the tip.
    normal
        (3,) of the plane of the axis and the centre.
    along
        (3,) the axis' direction towards the hub, by this picture alone.
    tilt, tilt_deviation
        Sine of the axis along the ray, towards the hub.
    """

    centre: Array
    ray: Array
    normal: Array
    along: Array
    tilt: float
    tilt_deviation: float

    @classmethod
    def of(cls, seen: Analysis, camera: Camera, T_wc: Pose) -> _Sight:
        """Take it from a picture."""
        shaft, v = seen.shaft, float(seen.tip.values[0])
        rows = np.array([v, v - SLANT_ROWS * shaft.scale])
        points = seen.frame.points_back(np.stack([shaft.axis_u(rows), rows], axis=1))
        d = T_wc.rotate(camera.rays(points))
        ray = unit(T_wc.rotate(camera.rays(seen.tip_px)))
        toward = d[1] - d[0]
        across = unit(toward - (toward @ ray) * ray)
        tilt = seen.scenery.tilt
        focal, centre = float(camera.K[0, 0]), seen.frame.points(camera.K[:2, 2])
        return cls(
            T_wc.t,
            ray,
            unit(np.cross(d[0], d[1])),
            np.sqrt(1 - tilt**2) * across + tilt * ray,
            tilt,
            tilt_deviation(shaft, v, focal, centre) + TILT_SLACK,
        )


def _axis(sights: list[_Sight]) -> Array:
    """Give the direction (3,) towards the hub that fits both planes and both tilts best."""
    axis = unit(np.sum([each.along for each in sights], axis=0))
    for _ in range(AXIS_STEPS):
        tangent = np.linalg.svd(axis[None])[2][1:].T
        rows, off = [], []
        for each in sights:
            rows += [each.normal / PLANE_RAD, each.ray / each.tilt_deviation]
            off += [
                -(each.normal @ axis) / PLANE_RAD,
                (each.tilt - each.ray @ axis) / each.tilt_deviation,
            ]
        step = np.linalg.lstsq(np.array(rows) @ tangent, np.array(off))[0]
        axis = unit(axis + tangent @ step)
    return axis


def _tip(sights: list[_Sight]) -> Array | None:
    """Give the point (3,) nearest to the planes of the axis, and less strictly to the rays."""
    rows, at = [], []
    for each in sights:
        beside = np.cross(each.ray, each.normal)
        for row in (each.normal, ALONG * beside):
            rows.append(row)
            at.append(float(row @ each.centre))
    A = np.array(rows)
    if np.linalg.svd(A)[1][-1] < PARALLEL * ALONG:
        return None
    return np.asarray(np.linalg.lstsq(A, np.array(at))[0])
