from __future__ import annotations

import json

import pytest
from asked import call

from simtip.bound_file import read_bound


def test_the_scalar_back_end_is_refused_in_one_line(scene_path):
    answer = call("bound", str(scene_path), "--backend", "scalar")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.count("\n") == 1
    assert "--backend: the scalar back end" in answer.err


def test_a_folder_in_use_is_refused_before_long_work(scene_path, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    answer = call("bound", str(scene_path), "-o", str(tmp_path))
    assert answer.code == 2
    assert str(tmp_path) in answer.err


@pytest.mark.slow
def test_json_and_folder_tell_the_same(tip_scene, tmp_path):
    scene = tmp_path / "scene.yaml"
    scene.write_text(json.dumps(tip_scene.model_dump(mode="json")))
    out = tmp_path / "out"
    answer = call("bound", str(scene), "--json", "-o", str(out), "--samples", "8")
    assert answer.code == 0, answer.err
    said, stored = json.loads(answer.out), json.loads((out / "bound.json").read_text())
    assert {key: stored[key] for key in said} == said
    assert set(said["bound_mm"]) == set(said["bound_known_mm"]) == {"x", "y", "z", "norm"}
    assert set(said["bound_axis_mm"]) == {"along", "across", "depth"}
    for side in ("left", "right"):
        assert set(said["bound_px"][side]) == {"along", "across"}
        assert (out / f"{side}_information.png").read_bytes().startswith(b"\x89PNG")
    assert set(said["convergence"]) == {"half_step", "half_samples", "noise_share"}
    read = read_bound(out / "bound.json")
    assert read.norm_mm == said["bound_mm"]["norm"]
    read.require_scene(tip_scene)
