"""Measuring the detectors: every row is kept at once, and nothing is worked out twice."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from regions import with_roi

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture
def bench(monkeypatch):
    monkeypatch.syspath_prepend(FOLDER)
    import detectors

    return detectors


@pytest.fixture
def tried(bench, monkeypatch, tmp_path, small_scene):
    """A measurement of two methods on two conditions, without images; what was done is listed."""
    done: list[tuple] = []

    def bounds_of(_, scenes):
        done.append(("bounds", len(scenes)))
        return {}

    def row(shots, method, _):
        if method == "breaks":
            raise KeyboardInterrupt
        done.append((shots.condition.name, method))
        return {"ms": 1.0}

    def conditions(*_):
        scenes = [small_scene, small_scene, small_scene]
        return [SimpleNamespace(name=n, group="g", scenes=lambda: scenes) for n in ("one", "two")]

    monkeypatch.setattr(bench.Bounds, "of", bounds_of)
    monkeypatch.setattr(bench, "row", row)
    monkeypatch.setattr(bench, "conditions", conditions)
    monkeypatch.setattr(bench, "methods_of", lambda names: {name: name for name in names})
    monkeypatch.setattr(bench, "STORED", tmp_path / "detectors.json")

    def run(*methods, **changes):
        done.clear()
        given = bench.options().parse_args(["--measure", "--method", *methods])
        vars(given).update(changes)
        bench.measure(given, lambda now: bench.keep_json(bench.STORED, now))
        return list(done)

    run.done = done
    run.stored = lambda: json.loads(bench.STORED.read_text())
    return run


def test_an_interrupted_measurement_goes_on_with_the_row_it_lacks(tried):
    with pytest.raises(KeyboardInterrupt):
        tried("a", "breaks")
    assert tried.done == [("bounds", 2), ("one", "a")]
    begun = tried.stored()["begun_utc"]
    assert list(tried.stored()["conditions"][0]["methods"]) == ["a"]
    assert tried("a", "b", resume=True) == [
        *[("bounds", 2), ("one", "b")],
        *[("bounds", 2), ("two", "a"), ("two", "b")],
    ]
    assert tried.stored()["begun_utc"] == begun
    assert tried("a", "b", resume=True) == []


def test_a_new_measurement_or_other_settings_begin_anew(tried):
    every = [("bounds", 2), ("one", "a"), ("bounds", 2), ("two", "a")]
    assert tried("a") == every
    assert tried("a", resume=True, poses=9) == every
    assert tried("a", resume=True, bounds=0)[0] == ("bounds", 0)
    assert tried("a") == tried("a") == every


def test_rows_of_others_stay(tried):
    tried("a")
    tried("b", only=["two"])
    one, two = tried.stored()["conditions"]
    assert (list(one["methods"]), list(two["methods"])) == (["a"], ["a", "b"])
    begun = {name: row["settings"]["begun_utc"] for name, row in two["methods"].items()}
    assert begun["a"] < begun["b"]


def test_a_bound_is_worked_out_once_and_found_again(bench, monkeypatch, tmp_path, small_scene):
    import detector_bounds

    asked = []

    def tip_bound(scene, **options):
        asked.append(options["check"])
        return SimpleNamespace(to_dict=lambda: {"bound_mm": {"norm": scene.needle.tip_mm[0]}})

    monkeypatch.setattr(detector_bounds, "tip_bound", tip_bound)
    other = with_roi(small_scene, [780, 800, 80, 90], [990, 795, 80, 90])
    noisier = with_roi(small_scene, [780, 800, 80, 100], [990, 795, 80, 100], samples=8)
    scenes = [small_scene, other, noisier]
    found = bench.Bounds(tmp_path).of(scenes)
    assert asked == [False, False]  # noise of the render changes no bound
    assert set(found) == {0, 1, 2}
    assert bench.Bounds(tmp_path).of(scenes) == found
    assert len(asked) == 2
    assert len(list((tmp_path / "bounds").iterdir())) == 2
    bench.Bounds(None).of(scenes)
    assert len(asked) == 4


@pytest.mark.usefixtures("bench")
def test_a_file_is_whole_or_as_it_was(tmp_path):
    import kept_file

    file = tmp_path / "a.json"
    kept_file.keep_json(file, {"a": 1})
    with pytest.raises(ValueError, match="JSON"):
        kept_file.keep_json(file, {"a": float("nan")})
    assert json.loads(file.read_text()) == {"a": 1}
    assert [one.name for one in tmp_path.iterdir()] == ["a.json"]


@pytest.mark.usefixtures("bench")
def test_the_refinement_is_a_method_of_both_images(scene, monkeypatch):
    import detector_methods

    monkeypatch.setattr(detector_methods, "refiner_of", lambda _: lambda *_: found)
    tips = np.array([[10.0, 20.0], [1e5, 0.0]])
    found = detector_methods.Refinement(
        "ok", tip_mm=np.ones(3), covariance_mm2=np.eye(3), tips_px=tips
    )
    method = detector_methods.methods_of(["silhouette"])["silhouette"]
    answer = method(scene)((None, None))
    assert answer.of_both
    assert answer.views[0].tip_px.tolist() == [10, 20]
    assert answer.views[1].tip_px is None  # outside the image: no tip is claimed in it
    assert answer.views[0].covariance_px is None
    assert answer.covariance_mm2.tolist() == np.eye(3).tolist()


def test_a_bent_needle_is_none_of_the_refinements(bench, scene):
    bent = scene.needle.model_copy(update={"bend_radius_mm": 400.0})
    shots = SimpleNamespace(scenes=[scene.model_copy(update={"needle": bent})])
    found = bench.row(shots, bench.methods_of(["silhouette"])["silhouette"], {})
    assert set(found) == {"refused"}
    assert "refine.name" in found["refused"]
