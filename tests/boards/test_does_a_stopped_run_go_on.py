"""Is a folder that was filled in pieces the one that is filled at once, whatever stopped it?"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from boards.board_scenes import small
from cli.command_line import one_line, snapshot

from simtip.boards import BoardSet, plan_boards
from simtip.boards_folder import check_folder, fill_folder
from simtip.errors import InputError
from simtip.render import choose
from simtip.scene_file import dump_scene, load_scene

NAMES = {"truth.json", "scene.yaml", "rig_true.yaml"}


@pytest.fixture(scope="module")
def boards(scene) -> BoardSet:
    return plan_boards(small(scene), seed=4)


@pytest.fixture
def drawn(monkeypatch) -> list[int]:
    """Put quick pictures in the place of rendered ones; gives the views that were drawn."""
    views: list[int] = []

    def picture(boards, k, *, progress, **_):
        views.append(k)
        progress(0.5)
        rng = np.random.default_rng([boards.seed, k])
        return tuple(rng.integers(0, 255, (20, 30, 3)).astype(np.uint8) for _ in range(2))

    monkeypatch.setattr("simtip.boards_folder.picture_board", picture)
    return views


def fill(folder: Path, boards: BoardSet, seen: list | None = None) -> tuple[int, int]:
    seen = [] if seen is None else seen
    return fill_folder(folder, boards, backend=choose(), progress=seen.append)


@pytest.mark.usefixtures("drawn")
def test_a_new_folder_holds_all_images_and_their_truth(tmp_path, boards):
    done: list[float] = []
    assert fill(tmp_path / "new" / "out", boards, done) == (3, 0)
    names = {f"{side}_0{k}.png" for side in ("left", "right") for k in (1, 2, 3)}
    assert set(snapshot(tmp_path / "new" / "out")) == names | NAMES
    assert done == sorted(done)
    assert done[-1] == 1
    assert done[0] == pytest.approx(1 / 6)


def test_only_what_is_missing_is_rendered(tmp_path, boards, drawn):
    fill(tmp_path / "out", boards)
    whole = snapshot(tmp_path / "out")
    (tmp_path / "out" / "right_02.png").unlink()
    drawn.clear()
    done: list[float] = []
    assert fill(tmp_path / "out", boards, done) == (1, 2)
    assert drawn == [1]
    assert done[0] == pytest.approx(2.5 / 3)
    assert snapshot(tmp_path / "out") == whole
    assert fill(tmp_path / "out", boards) == (0, 3)


@pytest.mark.usefixtures("drawn")
@pytest.mark.parametrize("kept", [0, 1, 100, -1])
def test_an_image_cut_short_is_rendered_again(tmp_path, boards, kept):
    """It cannot come from simtip, but from a copy or a power failure."""
    fill(tmp_path / "out", boards)
    whole = snapshot(tmp_path / "out")
    image = tmp_path / "out" / "left_03.png"
    image.write_bytes(image.read_bytes()[:kept])
    assert fill(tmp_path / "out", boards) == (1, 2)
    assert snapshot(tmp_path / "out") == whole


@pytest.mark.usefixtures("drawn")
def test_what_a_killed_run_left_is_removed(tmp_path, boards):
    fill(tmp_path / "out", boards)
    whole = snapshot(tmp_path / "out")
    (tmp_path / "out" / ".simtip-0123456789abcdef").write_bytes(b"half a picture")
    fill(tmp_path / "out", boards)
    assert snapshot(tmp_path / "out") == whole


@pytest.mark.usefixtures("drawn")
@pytest.mark.parametrize(
    "other",
    [
        pytest.param({"target": "chessboard:3x3:1.6"}, marks=pytest.mark.slow),
        pytest.param({"views": 2}, marks=pytest.mark.slow),
        pytest.param(
            {"plate": {"margin_mm": 0.5, "thickness_mm": 0.5, "bow_mm": 0.01}},
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_folder_of_another_set_is_refused(tmp_path, scene, boards, other):
    fill(tmp_path / "out", boards)
    before = snapshot(tmp_path / "out")
    for plan in (plan_boards(small(scene, **other), seed=4), plan_boards(small(scene), seed=5)):
        for refuse in (check_folder, fill):
            with pytest.raises(InputError, match=r"out: holds calibration images of another scene"):
                refuse(tmp_path / "out", plan)
    assert snapshot(tmp_path / "out") == before


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("notes.txt", "mine", "exists and is not empty"),
        ("truth.json", "{}", "holds something else than calibration images"),
        ("truth.json", "[" * 100_000, "holds something else than calibration images"),
        ("truth.json", "not JSON", "holds something else than calibration images"),
    ],
)
def test_a_foreign_folder_is_refused(tmp_path, boards, drawn, name, content, problem):
    (tmp_path / name).write_text(content)
    for refuse in (check_folder, fill):
        with pytest.raises(InputError, match=problem):
            refuse(tmp_path, boards)
    assert set(snapshot(tmp_path)) == {name}
    assert not drawn


@pytest.mark.slow
@pytest.mark.usefixtures("drawn")
def test_the_folders_own_scene_goes_on_with_it(tmp_path, boards):
    """Also when the scene named a rig that measures."""
    rig = boards.spec.rig.model_copy(update={"measured": str(tmp_path / "gone.yaml")})
    spec = boards.spec.model_copy(update={"rig": rig})
    out = tmp_path / "out"
    fill(out, plan_boards(spec, seed=4))
    again = load_scene(out / "scene.yaml")
    assert again.rig.measured is None
    assert fill(out, plan_boards(again)) == (0, 3)


@pytest.mark.usefixtures("drawn")
def test_a_full_disk_is_one_line(tmp_path, boards, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(InputError, match="No space left on device"):
        fill(tmp_path / "out", boards)
    assert snapshot(tmp_path) == {}


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="sends SIGKILL")
def test_kill_9_loses_no_bit(tmp_path, scene):
    views = 6
    (tmp_path / "scene.yaml").write_text(dump_scene(small(scene, views=views)))
    call = [sys.executable, "-m", "simtip", "boards", "scene.yaml", "--json", "-o"]
    quiet = {"cwd": tmp_path, "capture_output": True, "text": True}
    first = json.loads(subprocess.run([*call, "whole"], check=True, **quiet).stdout)
    assert (first["rendered"], first["found"]) == (views, 0)
    whole = snapshot(tmp_path / "whole")
    rng = np.random.default_rng(3)
    for wanted in (1, 4, 7, 9):
        process = subprocess.Popen(
            [*call, "pieces"], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        end = time.monotonic() + 120
        while len(list(tmp_path.glob("pieces/*.png"))) < wanted and time.monotonic() < end:
            time.sleep(0.002)
        time.sleep(rng.random() * 0.1)
        process.send_signal(signal.SIGKILL)
        process.wait()
        found = {k: v for k, v in snapshot(tmp_path / "pieces").items() if k[0] != "."}
        assert wanted <= len(found) - len(NAMES) < 2 * views
        assert {k: v for k, v in whole.items() if k in found} == found
    last = json.loads(subprocess.run([*call, "pieces"], check=True, **quiet).stdout)
    assert last["rendered"] + last["found"] == views
    assert last["found"] >= 3
    assert snapshot(tmp_path / "pieces") == whole
    for name in whole:
        if name.endswith(".png"):
            assert cv2.imread(str(tmp_path / "pieces" / name)) is not None


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="sends SIGINT")
def test_ctrl_c_keeps_what_there_is_and_says_how_to_go_on(tmp_path, scene):
    (tmp_path / "scene.yaml").write_text(dump_scene(small(scene, views=6)))
    call = [sys.executable, "-m", "simtip", "boards", "scene.yaml", "-o", "out"]
    process = subprocess.Popen(
        call, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    while not (tmp_path / "out" / "left_02.png").exists() and process.poll() is None:
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=120)
    assert process.returncode == 130
    assert one_line(stderr) == "interrupted; the same command goes on with out"
    assert not stdout
    left = snapshot(tmp_path / "out")
    assert not [name for name in left if name.startswith(".")]
    assert 3 + 3 <= len(left) < 3 + 12
    done = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert " were there" in done.stdout
    whole = snapshot(tmp_path / "out")
    assert len(whole) == 3 + 12
    assert {name: whole[name] for name in left} == left
    shutil.rmtree(tmp_path / "out")
