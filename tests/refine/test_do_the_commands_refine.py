"""`run` and `measure` with a refinement: what they give, and what they refuse."""

from __future__ import annotations

import json

import numpy as np
import pytest
import yaml
from regions import with_roi

from simtip.image_file import write_png
from simtip.rig_file import write_rig
from simtip.scene_file import dump_scene
from simtip.spec.scene import RefineSpec
from simtip.trial import run_trial

MEASURE = ("measure", "--rig", "rig.yaml", "left.png", "right.png")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--refine", "snake"), "--refine: 'snake' is no refinement; give none or silhouette"),
        (("--needle", "cone:1.67:5"), "--needle: is not used"),
        (("--refine", "silhouette"), "--refine silhouette: needs the needle's shape"),
        (("--refine", "silhouette", "--needle", "cone:1"), "--needle: 'cone:1' names no needle"),
        (("--refine", "silhouette", "--needle", "a.ply"), "a.ply: --needle: no such file"),
        (("--refine", "silhouette", "--needle", "a.obj"), "a.obj: --needle: is neither"),
    ],
)
def test_a_mistake_is_one_line(options, words, ask):
    answer = ask(*MEASURE, *options)
    assert (answer.code, answer.out) == (2, "")
    assert words in answer.err
    assert answer.err.count("\n") == 1


def test_a_scenes_bent_needle_is_refused_before_it_is_rendered(scene, ask, tmp_path):
    needle = scene.needle.model_copy(update={"bend_radius_mm": 400.0})
    bent = scene.model_copy(update={"needle": needle, "refine": RefineSpec(name="silhouette")})
    file = tmp_path / "bent.yaml"
    file.write_text(dump_scene(bent))
    answer = ask("run", str(file), "--json")
    assert (answer.code, answer.out) == (2, "")
    assert "refine.name: the needle has its hub's middle" in answer.err


def test_a_scene_that_says_nothing_is_not_refined(scene):
    assert scene.refine.name == "none"
    assert yaml.safe_load(dump_scene(scene))["refine"] == {"name": "none"}


@pytest.mark.slow
def test_run_and_measure_refine_alike(scene, ask, tmp_path):
    spec = with_roi(scene, [745, 560, 150, 360], [955, 560, 150, 360], noise=None, samples=256)
    spec = spec.model_copy(update={"refine": RefineSpec(name="silhouette")})
    trial = run_trial(spec, seed=2, detector="subpixel")
    result = trial.to_dict()
    refined = result["refined"]
    assert refined["status"] == "ok"
    assert result["tip_measured_mm"] == refined["tip_mm"]
    assert result["tip_covariance_mm2"] == refined["covariance_mm2"]
    assert result["error_mm"]["norm"] < 0.005
    off = np.array(result["tip_triangulated_mm"]) - result["tip_true_mm"]
    assert np.linalg.norm(off) > 1e-4
    assert result["timings_s"]["refine"] > 0
    for side, image in zip(("left", "right"), trial.simulation.images, strict=True):
        write_png(tmp_path / f"{side}.png", image)
    write_rig(tmp_path / "rig.yaml", trial.simulation.truth.rig)
    files = [str(tmp_path / name) for name in ("rig.yaml", "left.png", "right.png")]
    options = ("--detector", "subpixel", "--refine", "silhouette", "--needle", "cone:1.67:5")
    answer = ask("measure", "--rig", *files, *options, "--json")
    assert (answer.code, answer.err) == (0, "")
    again = json.loads(answer.out)
    np.testing.assert_allclose(again["tip_measured_mm"], refined["tip_mm"], atol=2e-5)
    # In the part that the tip is in, it is the same again, in pixels of the whole image.
    parts = ("--roi-left", "10,20,130,340", "--roi-right", "10,20,130,340")
    part = json.loads(ask("measure", "--rig", *files, *options, *parts, "--json").out)
    np.testing.assert_allclose(part["tip_measured_mm"], refined["tip_mm"], atol=2e-3)
    np.testing.assert_allclose(
        part["refined"]["tip_px"]["left"], refined["tip_px"]["left"], atol=0.03
    )
