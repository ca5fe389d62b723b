"""Pictures of calibration boards, and what is true of them.

Each view is a board in a pose of its own, lit, seen and exposed as the scene's needle would be; the
solid clutter is cleared away. The exposure, where the scene leaves it to the camera, brings the
board's bare plate to `sensor.background_dn`, in every view anew.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array, Pose
from simtip.noise_budget import noise_tolerance
from simtip.plate import Plate
from simtip.plate_poses import plate_poses
from simtip.render import Backend, Progress, View, render_board
from simtip.seeding import seed32
from simtip.sensor import Image
from simtip.simulation import expose_views
from simtip.spec import ClutterSpec, SceneSpec

BARE = 0.75
"""Quantile of the board's light that is the bare plate's: about half of the print is black."""
COVERED = 0.999

STROKE_MM = np.array([28.0, 22.0, 15.0])
"""Of the paper's robot: what the needle's tip may reach about the scene's (section 2.1)."""


@dataclass(frozen=True, eq=False)
class BoardSet:
    """A set of views of a calibration board, planned.

    Attributes
    ----------
    spec
        The scene.
    seed
        Root of all random numbers.
    plate
        The board.
    poses
        T_wt of each view, from the board's frame to the world, mm.
    """

    spec: SceneSpec
    seed: int
    plate: Plate
    poses: tuple[Pose, ...]

    def name(self, k: int) -> str:
        """Give view `k`'s name: its number from 1, in as many digits as the last's."""
        return f"{k + 1:0{max(2, len(str(len(self.poses))))}d}"

    def truth(self) -> dict[str, Any]:
        """Give what is true of all views, as plain data for ``truth.json``."""
        rig = self.spec.rig.rig()
        tip = np.array(self.spec.needle.tip_mm)
        plate = self.plate
        return {
            "world": "left camera frame, mm: x right, y down, z forward",
            "pixels": "(u, v), u right, v down; (0, 0) is the centre of the top-left pixel",
            "poses": "p_world = R p_board + t, mm; board: x along a row, y down the rows, z inward",
            "target": str(plate.target),
            "plate": {
                "margin_mm": plate.margin_mm,
                "thickness_mm": plate.thickness_mm,
                "bow_mm": plate.bow_mm,
                "print_scale": list(plate.print_scale),
                "points_mm": plate.points.tolist(),
            },
            "working_volume_mm": {
                "low": (tip - STROKE_MM / 2).tolist(),
                "high": (tip + STROKE_MM / 2).tolist(),
            },
            "image_size": {"left": list(rig.left.size), "right": list(rig.right.size)},
            "views": [self._view(k, pose) for k, pose in enumerate(self.poses)],
        }

    def _view(self, k: int, T_wt: Pose) -> dict[str, Any]:
        rig, name = self.spec.rig.rig(), self.name(k)
        world = T_wt.apply(self.plate.points)
        sides = {
            side: {"file": f"{side}_{name}.png", **_seen(pixels, camera.size)}
            for side, pixels, camera in zip(
                ("left", "right"), rig.project(world), (rig.left, rig.right), strict=True
            )
        }
        return {"name": name, "R": T_wt.R.tolist(), "t_mm": T_wt.t.tolist(), **sides}


def plan_boards(spec: SceneSpec, *, seed: int | None = None) -> BoardSet:
    """Choose the poses.

    Parameters
    ----------
    spec
        The scene; `boards` says what is shown how often.
    seed
        Root of all random numbers; by default the scene's own.

    Raises
    ------
    InputError
        Too few poses fit.
    """
    seed = spec.seed if seed is None else seed
    plate = spec.boards.build()
    spec = spec.model_copy(update={"clutter": ClutterSpec()})
    poses = plate_poses(spec, plate, spec.boards.views, seed)
    return BoardSet(spec, seed, plate, tuple(poses))


def picture_board(
    boards: BoardSet, k: int, *, backend: Backend, progress: Progress | None = None
) -> tuple[Image, Image]:
    """Render view `k` and expose both sensors to it.

    Parameters
    ----------
    boards
        The set.
    k
        Which view, from 0.
    backend
        What renders; not the scalar one.
    progress
        Called with the fraction rendered.

    Returns
    -------
    left, right
        (H, W, 3) RGB, DN; uint8 at 8 bit, uint16 above.

    Raises
    ------
    InputError
        The back end is scalar, or no exposure gives `sensor.background_dn`.
    """
    spec = boards.spec
    seed = seed32(boards.seed, "boards", k)
    views = render_board(
        spec,
        boards.plate,
        boards.poses[k],
        backend=backend,
        seed=seed,
        tolerance=noise_tolerance(spec),
        progress=progress,
    )
    _, images = expose_views(spec, views, seed=seed, level=_bare_plate)
    return images


def _bare_plate(irradiance: NDArray[np.float32], view: View) -> Array:
    pixels = irradiance[view.coverage >= COVERED * view.coverage.max()]
    level: Array = np.quantile(pixels, BARE, axis=0).astype(np.float64)
    return level


def _seen(pixels: Array, size: tuple[int, int]) -> dict[str, Any]:
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= -0.5) & (pixels <= np.array(size) - 0.5)).all(axis=1)
    return {"points_px": pixels.tolist(), "visible": inside.tolist()}
