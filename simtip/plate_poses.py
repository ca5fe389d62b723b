"""Where a calibration board is held: all over both images, near and far, tilted every way.

Poses are drawn evenly (scrambled Sobol points) in depth, tilt, roll and place in the left image.
Those are kept in which the whole plate is inside of both images, faces both cameras, stands before
the background and is sharp enough. Of them, each next view is the one that shows most points where
the images have seen fewest so far.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import qmc

from simtip.errors import InputError
from simtip.geometry import Array, Pose, unit
from simtip.plate import Plate
from simtip.seeding import stream
from simtip.spec import SceneSpec
from simtip.spec.boards import PosesSpec

POOL, POOL_PER_VIEW = 128, 4
"""Kept poses to choose from: at least so many, and so many for each view asked for."""
CANDIDATES = 1 << 15
CELLS = 8
"""Of each image, both ways, in which points are counted."""
LEAST_FACING = 0.35
"""Cosine between the board's normal and the way to a camera: 70 degrees."""
NEAREST_MM = 10.0

Cells = tuple[Array, Array]


def plate_poses(spec: SceneSpec, plate: Plate, views: int, seed: int) -> list[Pose]:
    """Choose poses of a plate before a rig.

    Parameters
    ----------
    spec
        The scene: its rig, background and `boards.poses`.
    plate
        What is held.
    views
        How many poses.
    seed
        Root seed. More views begin with the same ones as fewer, up to 32.

    Returns
    -------
    list of Pose
        T_wt, from the plate's frame to the world (the left camera's), mm.

    Raises
    ------
    InputError
        Too few poses fit; it says what most of them failed by.
    """
    sampler = _Sampler(spec, plate)
    wanted = max(POOL, POOL_PER_VIEW * views)
    numbers = qmc.Sobol(6, scramble=True, rng=stream(seed, "boards", "poses")).random(CANDIDATES)
    pool: list[Pose] = []
    cells: list[Cells] = []
    failed: Counter[str] = Counter()
    for row in numbers:
        pose = sampler.pose(row)
        reason = sampler.fault(pose)
        if reason:
            failed[reason] += 1
            continue
        pool.append(pose)
        cells.append(sampler.cells(pose))
        if len(pool) == wanted:
            break
    if len(pool) < views:
        raise _too_few(views, len(pool), failed)
    return [pool[k] for k in _spread(cells, views)]


class _Sampler:
    """Makes poses from numbers, and judges them."""

    def __init__(self, spec: SceneSpec, plate: Plate) -> None:
        self._poses: PosesSpec = spec.boards.poses
        self._plate = plate
        rig = spec.rig.rig()
        self._views = (
            (rig.left, Pose.identity(), spec.rig.left.lens.thin_lens()),
            (rig.right, rig.T_lr.inverse(), spec.rig.right.lens.thin_lens()),
        )
        distance = self._poses.distance_mm
        self._distance = spec.needle.tip_mm[2] if distance is None else distance
        forward = unit(np.array([0.0, 0, 1]) + rig.T_lr.R[:, 2])
        across = np.array([1.0, 0, 0]) + rig.T_lr.R[:, 0]
        across = unit(across - (across @ forward) * forward)
        self._base = np.stack([across, np.cross(forward, across), forward], axis=1)
        self._ground = np.array(spec.background.centre_mm)
        self._away = -unit(np.array(spec.background.normal))
        self._outline = plate.outline()
        # Bent, some of its back may be nearer to the background than the rim.
        places = np.stack(np.meshgrid(*np.linspace(plate.low, plate.high, 9).T), axis=-1)
        self._back = plate.surface(places.reshape(-1, 2))
        self._back[:, 2] += plate.thickness_mm
        self._points = plate.points

    def pose(self, numbers: Array) -> Pose:
        """Turn (6,) numbers from 0 to 1 into a pose."""
        depth, tilt, way, roll, u, v = numbers
        least, most = self._poses.tilt_deg
        angle = np.deg2rad(least + tilt * (most - least))
        about = 2 * np.pi * way
        tilted = Rotation.from_rotvec(angle * np.array([np.cos(about), np.sin(about), 0.0]))
        rolled = Rotation.from_rotvec([0, 0, np.deg2rad(self._poses.roll_deg * (2 * roll - 1))])
        R = self._base @ (tilted * rolled).as_matrix()
        camera = self._views[0][0]
        pixel = np.array([[u * camera.width - 0.5, v * camera.height - 0.5]])
        ray = camera.rays(pixel)[0]
        z = self._distance + self._poses.depth_mm * (2 * depth - 1)
        middle = ray / ray[2] * z
        return Pose(R, middle - R @ self._plate.middle)

    def fault(self, T_wt: Pose) -> str | None:
        """Say why a pose will not do; None if it will."""
        outline, back = T_wt.apply(self._outline), T_wt.apply(self._back)
        if not (((back - self._ground) @ self._away) < 0).all():
            return "reaches into the background"
        middle = T_wt.apply(self._plate.middle)
        for name, (camera, T_cw, lens) in zip(("left", "right"), self._views, strict=True):
            points = T_cw.apply(np.concatenate([outline, back]))
            if points[:, 2].min() < NEAREST_MM:
                return f"is not before the {name} camera"
            if unit(T_cw.apply(middle)) @ T_cw.rotate(T_wt.R[:, 2]) < LEAST_FACING:
                return f"is turned away from the {name} camera"
            pixels = camera.project(points)
            inside = (pixels >= self._poses.margin_px - 0.5) & (
                pixels <= np.array(camera.size) - 0.5 - self._poses.margin_px
            )
            if not inside.all():
                return f"leaves the {name} image"
            if lens is not None:
                depths = T_cw.apply(T_wt.apply(self._points))[:, 2]
                focal = float(max(camera.K[0, 0], camera.K[1, 1]))
                blur = max(lens.blur_px(focal, float(z)) for z in (depths.min(), depths.max()))
                if blur > self._poses.max_blur_px:
                    return "is out of focus"
        return None

    def cells(self, T_wt: Pose) -> Cells:
        """Count the target's points (CELLS, CELLS) in each image's cells."""
        points = T_wt.apply(self._points)
        left, right = (
            _counted(camera.project(T_cw.apply(points)), camera.size)
            for camera, T_cw, _ in self._views
        )
        return left, right


def _counted(pixels: Array, size: tuple[int, int]) -> Array:
    """Count points (n, 2) in an image's cells (CELLS, CELLS), rows first."""
    column, row = np.clip((pixels + 0.5) / size * CELLS, 0, CELLS - 1).astype(int).T
    counts = np.bincount(row * CELLS + column, minlength=CELLS**2)
    return counts.reshape(CELLS, CELLS).astype(np.float64)


def _spread(cells: list[Cells], views: int) -> list[int]:
    """Choose views, each the one that adds most where the images have seen least."""
    shown = np.sqrt(np.array(cells).reshape(len(cells), -1))
    seen = np.zeros(shown.shape[1])
    chosen: list[int] = []
    for _ in range(views):
        gain = (shown / (1 + seen)).sum(axis=1)
        gain[chosen] = -1
        best = int(gain.argmax())
        chosen.append(best)
        seen += shown[best]
    return chosen


def _too_few(views: int, found: int, failed: Counter[str]) -> InputError:
    total = sum(failed.values()) + found
    main = ", ".join(f"{count / total:.0%} {reason}" for reason, count in failed.most_common(3))
    remedies = {
        "leaves": "a smaller board, a greater distance_mm or less tilt_deg",
        "is out": "a larger max_blur_px or f-number, less tilt_deg or depth_mm",
        "reaches": "a background that is farther away, or less depth_mm",
    }
    worst = failed.most_common(1)[0][0] if failed else ""
    remedy = next((text for key, text in remedies.items() if worst.startswith(key)), None)
    return InputError(
        f"only {found} of {views} views fit: of {total} poses tried, the board {main}",
        field="boards.poses",
        remedy=f"try {remedy or 'another distance_mm, less tilt_deg or a smaller board'}",
    )
