"""Whatever is wrong with a folder is one line that names it, exit 2, and nothing is written."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from cli.command_line import one_line, snapshot


@pytest.fixture
def bench(tmp_path, monkeypatch, plain, boards) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(plain, tmp_path / "run")
    shutil.copytree(boards, tmp_path / "boards")
    (tmp_path / "empty").mkdir()
    return tmp_path


def cut(file: Path, kept: float) -> None:
    data = file.read_bytes()
    file.write_bytes(data[: int(len(data) * kept)])


def flip(file: Path) -> None:
    data = bytearray(file.read_bytes())
    data[-20] ^= 1
    file.write_bytes(data)


def moved_point() -> None:
    truth = json.loads(Path("boards/truth.json").read_text())
    truth["views"][0]["left"]["points_px"][0][0] += 0.01
    Path("boards/truth.json").write_text(json.dumps(truth))


def edited_hash() -> None:
    manifest = json.loads(Path("run/manifest.json").read_text())
    manifest["sha256"]["left.png"] = "0" * 64
    Path("run/manifest.json").write_text(json.dumps(manifest))


def other_truth() -> None:
    """As another version of simtip might have it: hashes right, truth and scene not alike."""
    tip = json.loads(Path("run/truth.json").read_text())["tip_mm"]
    with_truth(tip_mm=[tip[0] + 1e-3, *tip[1:]])


def huge_truth() -> None:
    """No float holds it."""
    with_truth(tip_mm=[10**400, 0, 0])


def with_truth(**parts: object) -> None:
    """Change the truth, and its hash with it."""
    import hashlib

    truth = json.loads(Path("run/truth.json").read_text()) | parts
    Path("run/truth.json").write_text(json.dumps(truth))
    manifest = json.loads(Path("run/manifest.json").read_text())
    data = Path("run/truth.json").read_bytes()
    manifest["sha256"]["truth.json"] = hashlib.sha256(data).hexdigest()
    Path("run/manifest.json").write_text(json.dumps(manifest))


def board_elsewhere() -> None:
    """With its digest made anew: the name alone is wrong."""
    from simtip.boards_folder import BESIDE_TRUTH, inputs_digest
    from simtip.scene_file import load_scene

    shutil.copy("boards/left_02.png", "left_02.png")
    truth = json.loads(Path("boards/truth.json").read_text())
    truth["views"][1]["left"]["file"] = "../left_02.png"
    own = {name: part for name, part in truth.items() if name not in BESIDE_TRUTH}
    scene = load_scene(Path("boards/scene.yaml"))
    truth["inputs_sha256"] = inputs_digest(scene, truth["seed"], own)
    Path("boards/truth.json").write_text(json.dumps(truth))


SPOILT = {
    "a number that no float holds": (huge_truth, "run", "truth.json: is no truth of a needle"),
    "a board's image elsewhere": (
        board_elsewhere,
        "boards",
        "truth.json: names '../left_02.png', which is no file of its folder",
    ),
    "a missing image": (lambda: Path("run/right.png").unlink(), "run", "right.png: is missing"),
    "an edited image": (lambda: flip(Path("run/left.png")), "run", "left.png: has been changed"),
    "an image cut short": (lambda: cut(Path("run/left.png"), 0.5), "run", "left.png: has been"),
    "an edited hash": (edited_hash, "run", "left.png: has been changed since"),
    "an edited scene": (lambda: flip(Path("run/scene.yaml")), "run", "scene.yaml: has been"),
    "an edited result": (lambda: flip(Path("run/result.json")), "run", "result.json: has been"),
    "no manifest": (lambda: Path("run/manifest.json").unlink(), "run", "run: is cut short"),
    "half a manifest": (
        lambda: cut(Path("run/manifest.json"), 0.5),
        "run",
        "manifest.json: is cut short or no JSON",
    ),
    "an empty manifest": (
        lambda: Path("run/manifest.json").write_text("{}"),
        "run",
        "manifest.json: sha256: lists no files",
    ),
    "another truth": (other_truth, "run", "truth.json: differs by 0.001"),
    "an empty folder": (lambda: None, "empty", "empty: holds no manifest.json"),
    "no folder": (lambda: None, "nowhere", "nowhere: no such folder"),
    "a file": (lambda: None, "run/left.png", "run/left.png: is not a folder"),
    "a board's image missing": (
        lambda: Path("boards/left_02.png").unlink(),
        "boards",
        "left_02.png: is missing",
    ),
    "a board's image cut short": (
        lambda: cut(Path("boards/right_03.png"), 0.7),
        "boards",
        "right_03.png: is cut short",
    ),
    "a board's point moved": (moved_point, "boards", "truth.json: inputs_sha256 is not that of"),
    "half a board's truth": (
        lambda: cut(Path("boards/truth.json"), 0.5),
        "boards",
        "truth.json: is cut short or no JSON",
    ),
}


@pytest.mark.parametrize("case", SPOILT)
@pytest.mark.parametrize("form", ["opencv", "csv"])
def test_what_is_wrong_is_named(case, form, bench, ask):
    spoil, folder, said = SPOILT[case]
    spoil()
    before = snapshot(bench)
    answer = ask("export", folder, "--format", form, "-o", "out")
    line = one_line(answer.err)
    assert answer.code == 2
    assert said in line
    assert "; " in line  # a remedy
    assert not answer.out
    assert snapshot(bench) == before


MISUSED = {
    "boards as bop": (["boards", "--format", "bop"], "--format bop: holds needles"),
    "needles and boards": (["run", "boards", "--format", "csv"], "boards: holds calibration"),
    "a condition without a sweep": (
        ["run", "--format", "csv", "--where", "repeat<5"],
        "--where: asks for trials",
    ),
    "undistorting for csv": (
        ["run", "--format", "csv", "--undistort"],
        "--undistort: is for bop",
    ),
    "no such format": (["run", "--format", "yolo"], "yolo"),
    "no folder": (["--format", "csv"], "DIR"),
    "an empty name": (["", "--format", "csv"], "is empty"),
    "no such back end": (["run", "--format", "csv", "--backend", "abacus"], "abacus"),
    "a back end that traces no masks": (
        ["run", "--format", "csv", "--backend", "scalar"],
        "--backend: the scalar back end traces no masks",
    ),
}


@pytest.mark.parametrize("case", MISUSED)
def test_what_does_not_go_together_is_said(case, bench, ask):
    arguments, said = MISUSED[case]
    before = snapshot(bench)
    answer = ask("export", *arguments, "-o", "out")
    assert said in one_line(answer.err)
    assert answer.code == 2
    assert snapshot(bench) == before


def test_a_folder_that_holds_something_is_not_written_to(bench, ask):
    (bench / "out").mkdir()
    (bench / "out" / "mine").write_text("kept")
    before = snapshot(bench)
    answer = ask("export", "run", "--format", "csv", "-o", "out")
    assert "exists and is not empty" in one_line(answer.err)
    assert snapshot(bench) == before


def test_an_export_that_fails_halfway_leaves_nothing(bench, ask):
    """The second folder's image is whole by its hash, and is no image."""
    shutil.copytree("run", "other")
    import hashlib

    Path("other/left.png").write_bytes(b"no image")
    manifest = json.loads(Path("other/manifest.json").read_text())
    manifest["sha256"]["left.png"] = hashlib.sha256(b"no image").hexdigest()
    Path("other/manifest.json").write_text(json.dumps(manifest))
    for form in ("bop", "coco", "opencv", "csv"):
        before = snapshot(bench)
        answer = ask("export", "run", "other", "--format", form, "-o", "out")
        assert "other/left.png: is not a PNG" in one_line(answer.err)
        assert snapshot(bench) == before


@pytest.mark.usefixtures("bench")
def test_a_name_that_holds_markup_is_said_as_it_is(ask):
    name = "<script>alert(1)<script>\x1b[2J"
    answer = ask("export", name, "--format", "csv", "-o", "out")
    line = one_line(answer.err)
    assert "<script>alert(1)<script>" in line
    assert "\x1b" not in line
