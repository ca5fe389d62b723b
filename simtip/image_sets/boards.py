"""A folder of `simtip boards`: a pair a view, the truth checked against its digest."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from simtip.boards_folder import BESIDE_TRUTH, DIGEST, TRUTH, inputs_digest
from simtip.calibration_images import read_board_truth
from simtip.errors import InputError
from simtip.geometry import Pose
from simtip.image_sets.images import read_taken
from simtip.image_sets.pairs import SIDES, BoardPair
from simtip.json_file import read_json
from simtip.scene_file import load_scene

SCENE = "scene.yaml"

RESTORE = "restore it, or render the boards anew"


class BoardFolder:
    """Pairs of images of a calibration board.

    Parameters
    ----------
    folder
        The folder.

    Raises
    ------
    InputError
        An image is missing, or the truth or the scene is not as it was written.
    """

    def __init__(self, folder: Path) -> None:
        self.source = str(folder)
        self._folder = folder
        self._spec = load_scene(folder / SCENE)
        found = read_json(folder / TRUTH, RESTORE)
        own = {name: part for name, part in found.items() if name not in BESIDE_TRUTH}
        seed = found.get("seed")
        if not isinstance(seed, int) or found.get(DIGEST) != inputs_digest(self._spec, seed, own):
            raise InputError(
                f"{DIGEST} is not that of it and {SCENE}: one was changed, or is another version's",
                file=folder / TRUTH,
                remedy=RESTORE,
            )
        self._truth = read_board_truth(folder / TRUTH)
        self._points = np.array(own["plate"]["points_mm"], dtype=np.float64)
        self._outline = self._spec.boards.build().outline()
        self._views: list[dict[str, Any]] = own["views"]
        for name in self._truth.pixels:
            if Path(name).name != name:
                raise InputError(
                    f"names {name[:80]!r}, which is no file of its folder",
                    file=folder / TRUTH,
                    remedy=RESTORE,
                )
            if not (folder / name).exists():
                raise InputError(
                    "is missing",
                    file=folder / name,
                    remedy="give the same `simtip boards` command again: it goes on",
                )

    def __len__(self) -> int:
        """Give the number of views."""
        return len(self._views)

    def pairs(self) -> Iterator[BoardPair]:
        """Give them in order."""
        rig = self._spec.rig.rig()
        for view in self._views:
            left, right = (
                read_taken(self._folder / view[side]["file"], camera, RESTORE)
                for side, camera in zip(SIDES, (rig.left, rig.right), strict=True)
            )
            yield BoardPair(
                source=self.source,
                label=f"view {view['name']}",
                images=(left, right),
                bit_depth=self._spec.sensor.bit_depth,
                rig=rig,
                target=self._truth.target,
                points_mm=self._points,
                outline_mm=self._outline,
                T_wt=Pose(np.array(view["R"]), np.array(view["t_mm"])),
                points_px=(
                    np.array(view["left"]["points_px"], dtype=np.float64),
                    np.array(view["right"]["points_px"], dtype=np.float64),
                ),
                visible=(
                    np.array(view["left"]["visible"], dtype=np.bool_),
                    np.array(view["right"]["visible"], dtype=np.bool_),
                ),
            )
