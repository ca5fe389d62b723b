"""`simtip boards`: its one line for every mistake, and its one JSON object."""

from __future__ import annotations

import json

import pytest
import yaml
from boards.board_scenes import small
from cli.command_line import in_a_process, one_line, snapshot

from simtip.scene_file import dump_scene


@pytest.fixture
def bench(tmp_path, monkeypatch, scene):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.yaml").write_text(dump_scene(small(scene)))
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--target", "nonsense"], "--target"),
        (["--target", "chessboard:1x8:6"], "--target"),
        (["--target", "charuco:12x9:6:7"], "--target"),
        (["--target", ""], "--target"),
        (["--views", "0"], "--views"),
        (["--views", "10001"], "--views"),
        (["--seed", "-1"], "--seed"),
        (["--backend", "scalar"], "--backend: the scalar back end renders no calibration boards"),
        (["--backend", "abacus"], "abacus"),
        (["--target", "chessboard:11x8:60"], "boards.poses: only 0 of 3 views fit"),
    ],
)
def test_a_wrong_option_is_one_line_and_leaves_nothing(bench, ask, arguments, said, monkeypatch):
    monkeypatch.setattr("simtip.plate_poses.CANDIDATES", 512)
    before = snapshot(bench)
    answer = ask("boards", "scene.yaml", "-o", "out", *arguments)
    assert answer.code == 2
    assert said in one_line(answer.err)
    assert not answer.out
    assert snapshot(bench) == before


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"target": "chessboard:11x8"}, "boards.target"),
        ({"target": "chessboard:1x8:6"}, "boards.target"),
        ({"target": 5}, "boards.target"),
        ({"views": 0}, "boards.views"),
        ({"views": 2.5}, "boards.views"),
        ({"plate": {"bow_mm": 21}}, "boards.plate.bow_mm"),
        ({"plate": {"print_scale": [1, 2]}}, "boards.plate.print_scale[1]"),
        ({"plate": {"edge_blur_mm": -1}}, "boards.plate.edge_blur_mm"),
        ({"plate": {"ink_albedo": [0.8, 0.8, 0.8]}}, "boards.plate.ink_albedo"),
        ({"plate": {"albedo": [1.2, 0.8, 0.8]}}, "boards.plate.albedo[0]"),
        ({"plate": {"margins_mm": 1}}, "boards.plate.margins_mm"),
        ({"poses": {"tilt_deg": [30, 5]}}, "boards.poses.tilt_deg"),
        ({"poses": {"max_blur_px": 0}}, "boards.poses.max_blur_px"),
        ({"poses": {"distance_mm": -170}}, "boards.poses.distance_mm"),
        ({"poses": {"depth_mm": ".inf"}}, "boards.poses.depth_mm"),
    ],
)
def test_a_wrong_value_is_named_with_its_line(bench, ask, change, field):
    text = (bench / "scene.yaml").read_text()
    kept, _, _ = text.partition("boards:")
    (bench / "scene.yaml").write_text(kept + yaml.safe_dump({"boards": change}))
    lines = (bench / "scene.yaml").read_text().splitlines()
    key = field.rpartition(".")[2].partition("[")[0]
    at = [k for k, line in enumerate(lines, 1) if k > kept.count("\n") and key in line]
    answer = ask("boards", "scene.yaml", "-o", "out")
    line = one_line(answer.err)
    assert answer.code == 2
    item = int(field[-2]) + 1 if field.endswith("]") else 0
    assert f"scene.yaml:{at[0] + item}: {field}: " in line
    assert not (bench / "out").exists()


@pytest.mark.slow
def test_json_is_one_object_and_a_second_call_finds_all(bench):
    call = ("boards", "scene.yaml", "-o", "out", "--views", "2", "--seed", "8", "--json")
    for rendered in (2, 0):
        done = in_a_process(*call, cwd=bench)
        assert done.returncode == 0, done.stderr
        said = json.loads(done.stdout)
        assert said["scene"] == "single tip"
        assert (said["views"], said["rendered"], said["found"]) == (2, rendered, 2 - rendered)
        assert said["target"] == "chessboard:3x3:1.5"
        assert (said["out"], said["seed"]) == ("out", 8)
    truth = json.loads((bench / "out" / "truth.json").read_text())
    assert truth["made_by"]["backend"]["variant"] == said["backend"]
    assert len(truth["views"]) == 2
    other = in_a_process(*call, "--seed", "9", cwd=bench)
    assert other.returncode == 2
    assert "another scene, target, seed or number of views" in one_line(other.stderr)
    plain = in_a_process(*call[:-1], cwd=bench)
    assert plain.stdout.splitlines()[0] == "0 views rendered, 2 were there"
    assert len(plain.stdout.splitlines()) == 2
