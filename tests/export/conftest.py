from __future__ import annotations

from pathlib import Path

import pytest
from boards.board_scenes import small as small_boards
from export.exported import distorted, occluded, run_into, small

from simtip.boards import plan_boards
from simtip.boards_folder import fill_folder
from simtip.render import choose


@pytest.fixture(scope="session")
def plain(scene, tmp_path_factory) -> Path:
    """A folder of `simtip run`: a cone, and a tip that was measured."""
    return run_into(tmp_path_factory.mktemp("plain") / "run", small(scene))


@pytest.fixture(scope="session")
def bevel(scene, tmp_path_factory) -> Path:
    """A folder of `simtip render`: a bevel, 12 bit."""
    spec = small(
        scene,
        needle={"tip": {"kind": "bevel", "angle_deg": 20}, "roll_deg": 30},
        sensor={"bit_depth": 12},
    )
    return run_into(tmp_path_factory.mktemp("bevel") / "rendered", spec, measured=False)


@pytest.fixture(scope="session")
def hidden(scene, tmp_path_factory) -> Path:
    """A needle with a cable before it."""
    return run_into(tmp_path_factory.mktemp("hidden") / "run", occluded(scene))


@pytest.fixture(scope="session")
def bent_lens(scene, tmp_path_factory) -> Path:
    """Images of lenses with distortion."""
    return run_into(tmp_path_factory.mktemp("distorted") / "run", distorted(scene))


@pytest.fixture(scope="session")
def boards(scene, tmp_path_factory) -> Path:
    """A folder of `simtip boards`, 3 views of 3 x 3 corners."""
    folder = tmp_path_factory.mktemp("boards") / "boards"
    backend = choose("llvm")
    fill_folder(folder, plan_boards(small_boards(scene)), backend=backend, progress=lambda _: None)
    return folder
