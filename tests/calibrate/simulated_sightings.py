"""Sightings made with a known rig, by cv2.projectPoints and not by simtip's own projection."""

from __future__ import annotations

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from simtip.calibrate import View
from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose, nearest_rotation
from simtip.target.sighting import Sighting

SIZE = (2048, 1436)

# Table 1 of the paper; it gives no distortion, so this is of a size that 6 mm lenses have
TABLE_1_R = nearest_rotation(
    [[0.862, -0.020, -0.507], [0.036, 0.999, 0.022], [0.506, -0.037, 0.861]]
)
TABLE_1_T = np.array([72.047, 2.138, 14.041])
LEFT_K = np.array([[1909.84, 0, 932.97], [0, 1910.22, 657.90], [0, 0, 1]])
RIGHT_K = np.array([[1923.38, 0, 935.88], [0, 1914.32, 729.04], [0, 0, 1]])
LEFT_D = (-0.11, 0.15, 0.0004, -0.0003, -0.05)
RIGHT_D = (-0.10, 0.12, -0.0003, 0.0005, -0.02)


def paper_rig(left_d=LEFT_D, right_d=RIGHT_D):
    left = Camera(LEFT_K, *SIZE, distortion=left_d)
    right = Camera(RIGHT_K, *SIZE, distortion=right_d)
    return StereoRig(left, right, Pose(TABLE_1_R, TABLE_1_T))


def grid(columns=11, rows=8, square_mm=6.0):
    """The corners of a chessboard, row by row: the paper's 88 by default."""
    y, x = np.mgrid[:rows, :columns] * square_mm
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]).astype(np.float64)


def seen(camera, T_cb, points):
    pixels, _ = cv2.projectPoints(
        points,
        Rotation.from_matrix(T_cb.R).as_rotvec(),
        T_cb.t,
        camera.K,
        np.array(camera.distortion or (0.0,) * 5),
    )
    return pixels.reshape(-1, 2)


def board_poses(rig, points, count, seed=0, tilt_deg=(5, 35), reach_mm=(25, 18, 20), depth_mm=170):
    """Boards about `depth_mm` away that face the cameras, tilt all ways and stay in both images."""
    rng = np.random.default_rng(seed)
    middle = points.mean(axis=0)
    facing = Rotation.from_rotvec([0, -np.radians(15), 0])  # between two cameras 30 degrees apart
    poses = []
    while len(poses) < count:
        towards, tilt = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(*tilt_deg))
        tilted = Rotation.from_rotvec([np.cos(towards) * tilt, np.sin(towards) * tilt, 0])
        R = (tilted * facing * Rotation.from_rotvec([0, 0, rng.uniform(-0.4, 0.4)])).as_matrix()
        at = np.array([0, 0, depth_mm]) + rng.uniform(-1, 1, 3) * reach_mm
        T_lb = Pose(R, at - R @ middle)
        left = seen(rig.left, T_lb, points)
        right = seen(rig.right, rig.T_lr.inverse() @ T_lb, points)
        if rig.left.contains(left).all() and rig.right.contains(right).all():
            poses.append(T_lb)
    return poses


def sightings(rig, points, poses, noise_px=0.0, seed=0, T_lr=None):
    """One view per pose, each corner with normal noise of its own in u and v."""
    rng = np.random.default_rng(seed)
    T_rl = (T_lr or rig.T_lr).inverse()
    ids = np.arange(len(points))
    views = []
    for i, T_lb in enumerate(poses):
        left = seen(rig.left, T_lb, points)
        right = seen(rig.right, T_rl @ T_lb, points)
        views.append(
            View(
                f"{i + 1:02d}",
                Sighting(ids, left + noise_px * rng.standard_normal(left.shape)),
                Sighting(ids, right + noise_px * rng.standard_normal(right.shape)),
            )
        )
    return views
