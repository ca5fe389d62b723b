"""`simtip view`: its one line for every mistake, and nothing left of what failed."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from cli.command_line import in_a_process, one_line, snapshot
from viewer.recorded import Recorded

from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose
from simtip.viewer.rays import ray_pair


@pytest.fixture
def bench(tmp_path, monkeypatch, plain) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(plain, tmp_path / "run")
    (tmp_path / "there.rrd").write_text("mine")
    return tmp_path


WRONG = {
    "another ending": (["run", "--save", "a.png"], "a.png: ends in '.png'"),
    "a file that is there": (["run", "--save", "there.rrd"], "there.rrd: exists"),
    "no folder for it": (["run", "--save", "no/a.rrd"], "its folder does not exist"),
    "no folder": (["nowhere", "--save", "a.rrd"], "nowhere: no such folder"),
    "a condition without a sweep": (
        ["run", "--save", "a.rrd", "--where", "repeat<5"],
        "--where: asks for trials",
    ),
    "no display": (["run"], "there is no display"),
}


@pytest.mark.parametrize("case", WRONG)
@pytest.mark.usefixtures("no_display")
def test_a_mistake_is_one_line(case, bench, ask):
    arguments, said = WRONG[case]
    before = snapshot(bench)
    answer = ask("view", *arguments)
    assert said in one_line(answer.err)
    assert answer.code == 2
    assert snapshot(bench) == before


@pytest.mark.slow
def test_without_rerun_it_says_how_to_get_it(bench):
    code = (
        "import importlib.util, sys\n"
        "found = importlib.util.find_spec\n"
        "importlib.util.find_spec = lambda name, *a: None if name == 'rerun' else found(name, *a)\n"
        "from simtip.cli import main; main()"
    )
    done = in_a_process("view", "run", "--save", "a.rrd", cwd=bench, code=code)
    assert done.returncode == 2
    assert one_line(done.stderr) == "simtip view needs rerun; pip install 'simtip[viewer]'"


def test_without_a_file_a_window_is_opened_and_told_all(bench, ask, monkeypatch):
    """The viewer's process stands aside: what it would be sent goes to a file."""
    monkeypatch.setenv("DISPLAY", ":0")
    opened = []

    def spawn(self, **_: object) -> None:
        opened.append(self)
        self.save(bench / "window.rrd")

    monkeypatch.setattr("rerun.RecordingStream.spawn", spawn)
    answer = ask("view", "run")
    assert answer.code == 0, answer.err
    assert len(opened) == 1
    opened[0].disconnect()
    assert "/world/tip/measured" in Recorded(bench / "window.rrd").entities()


def test_a_viewer_that_does_not_start_is_one_line(bench, ask, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":0")

    def spawn(*_: object, **__: object) -> None:
        raise RuntimeError("Failed to find Rerun Viewer executable in PATH.\n  Install it")

    monkeypatch.setattr("rerun.RecordingStream.spawn", spawn)
    before = snapshot(bench)
    answer = ask("view", "run")
    assert answer.code == 2
    assert "the viewer cannot be opened (Failed to find Rerun Viewer" in one_line(answer.err)
    assert snapshot(bench) == before


def test_a_folder_that_turns_out_spoilt_leaves_no_file(bench, ask, monkeypatch):
    """Its image cannot be read when its turn comes."""
    from simtip.errors import InputError

    def broken(*_: object) -> None:
        raise InputError("is cut short", file="left.png", remedy="copy it again")

    monkeypatch.setattr("simtip.image_sets.result.read_taken", broken)
    before = snapshot(bench)
    answer = ask("view", "run", "--save", "a.rrd")
    assert "left.png: is cut short" in one_line(answer.err)
    assert answer.code == 2
    assert snapshot(bench) == before


def test_two_rays_are_nearest_where_the_closed_form_says():
    """Rays along x at y = 0 and along z at x = 3, y = 2: 2 mm apart."""
    K = np.array([[100.0, 0, 0], [0, 100.0, 0], [0, 0, 1]])
    camera = Camera(K, 10, 10)
    turned = Pose(np.eye(3), np.array([3.0, 2.0, -50.0]))
    rig = StereoRig(camera, camera, turned)
    rays = ray_pair(rig, np.array([300.0, 0.0]), np.array([0.0, 0.0]))
    # The left ray is (3, 0, 1) t, the right one (3, 2, s): nearest at t = 1, s = 1.
    assert rays.gap_mm == pytest.approx(2)
    assert np.allclose(rays.nearest_mm, [[3, 0, 1], [3, 2, 1]])
    assert np.allclose(rays.centres_mm, [[0, 0, 0], [3, 2, -50]])


def test_parallel_rays_have_no_nearest_points():
    camera = Camera(np.array([[100.0, 0, 5], [0, 100.0, 5], [0, 0, 1]]), 10, 10)
    rig = StereoRig(camera, camera, Pose(np.eye(3), np.array([10.0, 0, 0])))
    assert ray_pair(rig, np.array([3.0, 3.0]), np.array([3.0, 3.0])) is None
