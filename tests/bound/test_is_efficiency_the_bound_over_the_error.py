"""Efficiency of one trial and of many, and that no bound of another scene is taken for it."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
from bound_scenes import changed

from simtip.bound import KnownBound, bound_digests, efficiency, pooled_efficiency
from simtip.console import show_result
from simtip.detect import TipObservation, TipStatus
from simtip.errors import InputError
from simtip.measure import Measurement
from simtip.refine import Refinement, RefineStatus
from simtip.score import score_tip
from simtip.spec.room import RoomSpec
from simtip.trial import Trial, run_trial
from simtip.triangulate import TipEstimate, TriangulationStatus

TRUE_MM = np.array([1.0, 2.0, 3.0])


SEEN = TipObservation(TipStatus.OK, tip_px=np.array([1.0, 2.0]))


def trial(norm_mm, *, triangulated=None, refined=None) -> Trial:
    """A trial that is off by so much in x and in z; None is nothing measured."""
    estimate = refinement = None
    if triangulated is not None:
        point = TRUE_MM + np.array([triangulated, 0, 0])
        estimate = TipEstimate(TriangulationStatus.OK, "", "svd", point)
    if refined is not None:
        refinement = Refinement(RefineStatus.OK, tip_mm=TRUE_MM + np.array([0, 0, refined]))
    measured = Measurement(SEEN, SEEN, None, estimate, refinement)
    known = None if norm_mm is False else KnownBound(norm_mm, {})
    simulation = SimpleNamespace(truth=SimpleNamespace(tip_mm=TRUE_MM))
    return Trial(simulation, measured, score_tip(), known)


def test_each_result_of_a_trial_has_its_own():
    told = trial(0.02, triangulated=-0.08, refined=0.01).efficiency()
    assert told == {
        "bound_mm": 0.02,
        "triangulated": pytest.approx(0.25),
        "refined": pytest.approx(2),  # one trial may be lucky
    }


def test_what_is_not_there_has_none():
    assert trial(False, triangulated=0.1).efficiency() is None
    assert trial(0.02).efficiency() == {"bound_mm": 0.02, "triangulated": None, "refined": None}
    told = trial(None, triangulated=0.1).efficiency()
    assert told == {"bound_mm": None, "triangulated": None, "refined": None}
    assert efficiency(0.1, 0.0) is None
    assert efficiency(float("inf"), 0.1) is None


def test_many_trials_pool_squares_over_those_that_measured():
    bounds, errors = [3.0, 4.0, 100.0], [6.0, -8.0, None]
    assert pooled_efficiency(bounds, errors) == pytest.approx(0.5)
    assert pooled_efficiency([1.0, 7.0], [5.0, 5.0]) == pytest.approx(1)  # not the mean, 0.8
    assert pooled_efficiency([1.0, None], [5.0, 5.0]) is None
    assert pooled_efficiency([1.0], [None]) is None
    assert pooled_efficiency([], []) is None
    with pytest.raises(ValueError, match="shorter"):
        pooled_efficiency([1.0, 2.0], [1.0])


def test_a_known_variance_has_efficiency_1():
    rng = np.random.default_rng(1)
    bounds = rng.uniform(0.5, 2, 20000)
    errors = np.linalg.norm(rng.normal(0, 1, (3, 20000)) * bounds / np.sqrt(3), axis=0)
    assert pooled_efficiency(bounds.tolist(), errors.tolist()) == pytest.approx(1, rel=0.02)


MATTERS = {
    "rig": {"rig": {"t_mm": (72.0, 2.138, 14.041)}},
    "needle": {"needle": {"roll_deg": 1.0}},
    "background": {"background": {"albedo": (0.5, 0.5, 0.5)}},
    "clutter": {"clutter": {"level": "light"}},
    "ambient": {"ambient": {"radiance_w_m2_sr": (0.1, 0.1, 0.1)}},
    "room": {"room": {}},
    "sensor": {"sensor": {"exposure_s": 0.01}},
    "render": {"render": {"light_step_mm": 1.0}},
}
DOES_NOT = {
    "name": {"name": "another"},
    "detector": {"detect": {"name": "subpixel"}},
    "matching": {"match": {"max_distance_px": 5.0}},
    "triangulation": {"triangulate": {"method": "optimal"}},
    "refinement": {"refine": {"name": "silhouette"}},
    "measuring rig": {"rig": {"measured": "other.yaml"}},
    "noise asked for": {"render": {"noise": 1.0}},
    "samples": {"render": {"samples": 16}},
    "seed": {"seed": 99},
}


def with_changes(scene, changes):
    plain = {key: value for key, value in changes.items() if not isinstance(value, dict)}
    parts = {key: value for key, value in changes.items() if isinstance(value, dict)}
    if "room" in parts:
        return scene.model_copy(update={"room": RoomSpec()})
    return changed(scene, **parts).model_copy(update=plain)


@pytest.mark.parametrize("part", MATTERS)
def test_another_scenes_bound_is_refused_with_the_part_that_differs(scene, part):
    bound = KnownBound(1.0, bound_digests(scene), "b.json")
    with pytest.raises(InputError, match=f"not the same {part}") as refused:
        bound.require_scene(with_changes(scene, MATTERS[part]))
    assert (refused.value.file, refused.value.field) == ("b.json", f"inputs_sha256.{part}")
    assert "simtip bound SCENE" in refused.value.remedy


def test_other_lamps_are_another_scene(scene):
    lamps = [lamp.model_dump() for lamp in scene.lamps]
    lamps[0]["power"] = 0.5
    with pytest.raises(InputError, match="not the same lamps"):
        KnownBound(1.0, bound_digests(scene)).require_scene(changed(scene, lamps=lamps))


@pytest.mark.parametrize("part", DOES_NOT)
def test_how_it_is_measured_is_no_other_scene(scene, part):
    KnownBound(1.0, bound_digests(scene)).require_scene(with_changes(scene, DOES_NOT[part]))


def test_the_seed_counts_where_it_places_what_is_seen(scene):
    cluttered = changed(scene, clutter={"level": "light"})
    bound = KnownBound(1.0, bound_digests(cluttered, 5))
    bound.require_scene(cluttered, 5)
    for seed in (None, 6):
        with pytest.raises(InputError, match="not the same seed"):
            bound.require_scene(cluttered, seed)
    assert bound_digests(scene, 1) == bound_digests(scene, 2)


def test_a_trial_refuses_anothers_bound_before_it_renders(scene, small_scene, monkeypatch):
    monkeypatch.setattr("simtip.simulation.render_pair", lambda *_, **__: pytest.fail("rendered"))
    with pytest.raises(InputError, match="another scene"):
        run_trial(small_scene, bound=KnownBound(1.0, bound_digests(scene)))


@pytest.mark.parametrize(
    ("told", "line"),
    [
        (
            {"bound_mm": 0.000521, "triangulated": 0.00072, "refined": 0.5},
            "bound 0.000521 mm, efficiency: triangulated 0.00072, refined 0.5",
        ),
        ({"bound_mm": 0.02, "triangulated": 1.0, "refined": None}, "efficiency: triangulated 1"),
        ({"bound_mm": 0.02, "triangulated": None, "refined": None}, "nothing was measured"),
        ({"bound_mm": None, "triangulated": None, "refined": None}, "do not determine the tip"),
    ],
)
def test_the_terminal_says_it_in_a_line(told, line, capsys):
    pixels = {"left": None, "right": None}
    result = {
        "status": "ok",
        "tip_measured_mm": None,
        "tip_detected_px": pixels,
        "timings_s": {},
        "detector": "d",
        "epipolar_distance_px": None,
    }
    show_result({**result, "efficiency": told})
    assert line in capsys.readouterr().out
    show_result({**result, "efficiency": None})
    assert "bound" not in capsys.readouterr().out


@pytest.mark.slow
def test_run_reports_the_files_bound_over_its_error(ask, tmp_path, small_scene, bound_json):
    scene, file = tmp_path / "scene.yaml", tmp_path / "b.json"
    spec = changed(small_scene, render={"samples": 16})
    scene.write_text(json.dumps(spec.model_dump(mode="json")))
    file.write_text(json.dumps(bound_json(spec, norm_mm=0.05)))
    out = tmp_path / "out"
    settings = ("--set", "min_area_px=200")
    answer = ask("run", str(scene), "--bound", str(file), *settings, "--json", "-o", str(out))
    assert answer.code == 0, answer.err
    result = json.loads(answer.out)
    assert result["status"] == "ok"
    assert result["efficiency"] == {
        "bound_mm": pytest.approx(0.05),
        "triangulated": pytest.approx(0.05 / result["error_mm"]["norm"]),
        "refined": None,
    }
    assert json.loads((out / "result.json").read_text()) == result
