"""A needle's place in the rig's frame, and small changes of it."""

from __future__ import annotations

import numpy as np

from simtip.camera import StereoRig
from simtip.detect.subpixel.analysis import Analysis
from simtip.geometry import Array, Pose, skew, unit

SLANT_ROWS = 0.5
"""Of the shaft's rows: how far up its second point is taken."""


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
    """Put a needle where the axes seen in both pictures meet, its roll unknown.

    Each picture's axis and the camera's centre span a plane; the planes meet in the needle's axis.
    None if they are all but parallel, or the needle would be behind a camera.
    """
    eyes = (rig.left, Pose.identity(), left), (rig.right, rig.T_lr, right)
    normals: list[Array] = []
    rays: list[Array] = []
    centres: list[Array] = []
    toward: list[Array] = []
    for camera, T_wc, seen in eyes:
        v = float(seen.tip.values[0])
        rows = np.array([v, v - SLANT_ROWS * seen.shaft.scale])
        points = seen.frame.points_back(np.stack([seen.shaft.axis_u(rows), rows], axis=1))
        d = T_wc.rotate(camera.rays(points))
        normals.append(unit(np.cross(d[0], d[1])))
        rays.append(T_wc.rotate(camera.rays(seen.tip_px)))
        centres.append(T_wc.t)
        toward.append(d[1] - d[0])
    line = np.cross(normals[0], normals[1])
    if np.linalg.norm(line) < 1e-3:
        return None
    axis = unit(line)
    axis = axis if axis @ (toward[0] + toward[1]) > 0 else -axis
    A = np.stack([normals[0], normals[1], axis])
    at = [float(n @ centre) for n, centre in zip(normals, centres, strict=True)]
    through = np.linalg.solve(A, np.array([*at, 0.0]))
    along = []
    for centre, ray in zip(centres, rays, strict=True):
        # Where the axis comes nearest to the ray of the tip.
        M = np.stack([axis, -ray], axis=1)
        along.append(float(np.linalg.lstsq(M, centre - through, rcond=None)[0][0]))
    tip = through + float(np.mean(along)) * axis
    if tip[2] <= 0 or rig.T_lr.inverse().apply(tip)[2] <= 0:
        return None
    x = unit(np.cross(axis, [0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0.0, 0.0]))
    return Pose(np.stack([x, np.cross(axis, x), axis], axis=1), tip)
