from __future__ import annotations

from pathlib import Path

import pytest
from boards.board_scenes import small as small_boards
from export.exported import distorted, occluded, run_once, small
from made_once import made_once

from simtip.boards import plan_boards
from simtip.boards_folder import fill_folder
from simtip.render import choose


@pytest.fixture(scope="session")
def plain(scene, tmp_path_factory) -> Path:
    """A folder of `simtip run`: a cone, and a tip that was measured."""
    return run_once(tmp_path_factory, "plain", small(scene))


@pytest.fixture(scope="session")
def bevel(scene, tmp_path_factory) -> Path:
    """A folder of `simtip render`: a bevel, 12 bit."""
    spec = small(
        scene,
        needle={"tip": {"kind": "bevel", "angle_deg": 20}, "roll_deg": 30},
        sensor={"bit_depth": 12},
    )
    return run_once(tmp_path_factory, "bevel", spec, measured=False)


@pytest.fixture(scope="session")
def hidden(scene, tmp_path_factory) -> Path:
    """A needle with a cable before it."""
    return run_once(tmp_path_factory, "hidden", occluded(scene))


@pytest.fixture(scope="session")
def bent_lens(scene, tmp_path_factory) -> Path:
    """Images of lenses with distortion."""
    return run_once(tmp_path_factory, "bent_lens", distorted(scene))


@pytest.fixture(scope="session")
def boards(scene, tmp_path_factory) -> Path:
    """A folder of `simtip boards`, 3 views of 3 x 3 corners."""

    def make(folder: Path) -> None:
        plan = plan_boards(small_boards(scene))
        fill_folder(folder / "boards", plan, backend=choose("llvm"), progress=lambda _: None)

    return made_once(tmp_path_factory, "small_boards", make) / "boards"
