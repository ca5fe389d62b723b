"""The figures of docs/detectors.md: computed as its text says, and those that are stored."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "benchmarks"


@pytest.fixture
def bench(monkeypatch):
    """The script, with its neighbours importable."""
    monkeypatch.syspath_prepend(FOLDER)
    import detectors

    return detectors


SETTINGS = {"bound_poses": 2, "bound_samples": 256}


def pair(
    trials,
    along,
    across,
    *,
    pose=0,
    claimed=None,
    error_mm=(0.1, 0.0, 0.0),
    claimed_mm2=None,
    in_view=(True, True),
    of_both=False,
):
    looks = tuple(
        trials.Look(pose, side, seen, "ok", along, across, 18.0, claimed)
        for side, seen in zip(("left", "right"), in_view, strict=True)
    )
    return trials.Try(looks, trials.Place(error_mm, claimed_mm2), 0.01, of_both)


def bound(norm_mm, along_px=0.1, across_px=0.05):
    view = {"along": along_px, "across": across_px}
    return {"bound_px": {"left": view, "right": view}, "bound_mm": {"norm": norm_mm}}


@pytest.fixture
def trials(monkeypatch):
    monkeypatch.syspath_prepend(FOLDER)
    import detector_trials

    return detector_trials


def test_bias_and_rmse_are_of_right_tips_alone(bench, trials):
    tried = [pair(trials, a, 0.5) for a in (8.0, 10.0)] + [
        pair(trials, -90.0, 20.0, error_mm=(9.0, 0, 0))
    ]
    found = bench.figures(tried)
    assert (found["found"], found["right"]) == (1, pytest.approx(2 / 3))
    assert found["bias_px"] == {"along": 9, "across": 0.5}
    assert found["rmse_px"]["along"] == pytest.approx(np.sqrt(82))
    assert (found["pairs_right"], found["largest_mm"]) == (2, 0.1)
    assert found["ms"] == pytest.approx(10)


def test_no_tip_lowers_the_rate_and_gives_no_number(bench, trials):
    none = trials.Look(0, "left", True, "no_edge", None, None, 18.0, None)
    found = bench.figures([trials.Try((none, none), None, 0.01)])
    assert (found["found"], found["right"]) == (0, 0)
    assert found["statuses"] == {"no_edge": 2}
    for name in (
        "bias_px",
        "rmse_px",
        "rmse_mm",
        "scatter_px",
        "claimed_to_scatter",
        "efficiency_mm",
    ):
        assert found[name] is None


def test_a_tip_in_an_image_without_one_is_false(bench, trials):
    found = bench.figures([pair(trials, 1.0, 0.0, in_view=(True, False))])
    assert (found["images"], found["found"], found["false"], found["empty"]) == (1, 1, 1, 1)
    assert found["pairs_right"] == 0


def test_claims_are_judged_by_fresh_noise_and_not_by_bias(bench, trials):
    rng = np.random.default_rng(1)
    tried = [
        pair(trials, 5 * pose + rng.normal(0, 0.2), rng.normal(0, 0.1), pose=pose,
             claimed=(0.04, 0.04))
        for pose in range(4)
        for _ in range(400)
    ]  # fmt: skip
    found = bench.figures(tried)
    assert found["scatter_px"]["along"] == pytest.approx(0.2, rel=0.06)
    assert found["claimed_to_scatter"]["along"] == pytest.approx(1, rel=0.06)
    assert found["claimed_to_scatter"]["across"] == pytest.approx(2, rel=0.06)


def test_efficiency_is_bound_over_rmse(bench, trials):
    found = bench.figures([pair(trials, 0.2, 0.2)], {0: bound(0.02)})
    assert found["efficiency_px"] == {"along": pytest.approx(0.5), "across": pytest.approx(0.25)}
    assert found["efficiency_mm"] == pytest.approx(0.2)
    assert found["efficiency_poses"] == 1
    small = bench.figures([pair(trials, 0.2, 0.2)], {0: bound(0.000021)})
    assert "| 0.00021 |" in bench.table(shown({"lin2020": small | {"settings": SETTINGS}}))


def test_efficiency_is_over_the_poses_with_a_bound_alone(bench, trials):
    tried = [
        pair(trials, 0.2, 0.2, pose=pose, error_mm=(0, error, 0))
        for pose, error in ((0, 0.3), (0, 0.3), (1, -0.4), (2, 9.0))
    ]
    found = bench.figures(tried, {0: bound(0.01), 1: bound(0.07), 3: bound(5.0)})
    squares = (0.01**2 + 0.01**2 + 0.07**2) / (0.3**2 + 0.3**2 + 0.4**2)
    assert found["efficiency_mm"] == pytest.approx(np.sqrt(squares))
    assert found["efficiency_poses"] == 2
    assert bench.figures(tried, {7: bound(0.01)})["efficiency_mm"] is None
    assert bench.figures(tried)["efficiency_poses"] == 0


def test_a_method_of_both_images_says_nothing_of_one(bench, trials):
    rng = np.random.default_rng(1)
    tried = [
        pair(trials, 0.1, 0.1, pose=pose, of_both=True, claimed_mm2=(0.04**2, 2 * 0.03**2),
             error_mm=(pose + rng.normal(0, 0.02), *rng.normal(0, 0.03, 2)))
        for pose in (0, 1)
        for _ in range(800)
    ]  # fmt: skip
    found = bench.figures(tried)
    assert (found["found"], found["right"]) == (1, 1)
    for name in ("bias_px", "rmse_px", "scatter_px", "claimed_to_scatter", "efficiency_px"):
        assert found[name] is None
    # Claims are judged about each pose's mean, along the needle and square to it.
    assert found["claimed_to_scatter_mm"]["along"] == pytest.approx(2, rel=0.06)
    assert found["claimed_to_scatter_mm"]["across"] == pytest.approx(1, rel=0.06)
    assert found["rmse_mm"] > 0.5
    assert "| 2." in bench.table(shown({"silhouette": found}))


def shown(methods):
    versions = {"versions": {"simtip": "0"}, "cpu_usable": 1, "platform": "here"}
    entry = {"group": "nominal", "name": "cone", "methods": methods}
    return {"environment": versions, "conditions": [entry]}


def test_the_table_says_what_efficiency_is_over_and_what_was_not_tried(bench, trials):
    found = bench.figures([pair(trials, 0.2, 0.2)], {0: bound(0.02)})
    methods = {"lin2020": found | {"settings": SETTINGS}, "silhouette": {"refused": "bent"}}
    text = bench.table(shown(methods))
    assert "over the pairs at the first 2 poses" in text
    assert "256 samples" in text
    line = text.splitlines()[-1]
    assert "`silhouette` |  | not for this needle |" in line
    assert line.count("|") == text.splitlines()[-3].count("|")
    without = bench.figures([pair(trials, 0.2, 0.2)]) | {"settings": SETTINGS}
    assert "Efficiency" not in bench.table(shown({"lin2020": without}))


def test_the_page_shows_the_stored_figures(bench):
    stored = json.loads(bench.STORED.read_text(encoding="utf-8"))
    text = bench.PAGE.read_text(encoding="utf-8")
    assert stored["quick"] is False
    assert bench.written(text, bench.table(stored)) == text
    stored["conditions"][0]["methods"]["lin2020"]["ms"] += 1000
    assert bench.written(text, bench.table(stored)) != text


def test_the_page_shows_the_stored_scatter(bench):
    import scatter

    text = bench.PAGE.read_text(encoding="utf-8")
    stored = json.loads(scatter.STORED.read_text(encoding="utf-8"))
    assert stored["quick"] is False
    assert scatter.written(text, scatter.table(stored)) == text
    stored["rows"][0]["scatter_px"]["across"] *= 2
    assert scatter.written(text, scatter.table(stored)) != text


def test_scatter_is_that_of_fresh_noise_over_the_bound(trials):
    import scatter

    rng = np.random.default_rng(4)
    errors = rng.normal([0.3, -0.1], [0.02, 0.004], (4000, 2))
    looks = [
        trials.Look(0, "left", True, "ok", along, across, 18.0, (0.03**2, 0.004**2))
        for along, across in errors
    ]
    row = scatter.view_row(looks, {"along": 0.01, "across": 0.001})
    assert row["scatter_px"]["along"] == pytest.approx(0.02, rel=0.05)
    assert row["scatter_px"]["across"] == pytest.approx(0.004, rel=0.05)
    assert row["claimed_px"] == pytest.approx({"along": 0.03, "across": 0.004})
    cells = scatter.table({"rows": [{"condition": "x", "pose": 0, "view": "left"} | row]})
    assert cells.splitlines()[-1].endswith("| 2.0 | 4.0 | 3.0 | 4.0 |")


def test_the_page_and_the_figures_name_every_hard_scene(bench):
    names = {file.stem for file in (ROOT / "scenes" / "hard").glob("*.yaml")}
    text = bench.PAGE.read_text(encoding="utf-8").partition(bench.BEGIN)[0]
    assert {name for name in names if f"`{name}`" not in text} == set()
    stored = json.loads(bench.STORED.read_text(encoding="utf-8"))
    assert {one["name"] for one in stored["conditions"] if one["group"] == "hard"} == names


@pytest.mark.slow
def test_every_condition_is_possible(bench):
    every = bench.conditions(poses=1, exposures=2)
    assert len({(one.group, one.name) for one in every}) == len(every)
    for condition in every:
        if condition.group != "hard":
            (scene,) = condition.scenes()
            assert scene.rig.left.roi[2:] == scene.rig.right.roi[2:] == (320, 800)


@pytest.mark.usefixtures("bench")
def test_lossy_storage_keeps_the_picture_in_place():
    import lossy_storage

    v, u = np.mgrid[:41, :61]
    image = np.repeat((120 + 60 * np.sin(u / 9) * np.cos(v / 7))[..., None], 3, axis=2)
    image = image.astype(np.uint8) - np.array([0, 10, 30], np.uint8)
    for store in (lossy_storage.jpeg, lossy_storage.mpeg4):
        back = store(image)
        assert back.shape == image.shape
        difference = back.astype(float) - image
        assert 0 < np.abs(difference).mean() < 4
        assert np.abs(difference.mean(axis=(0, 1))).max() < 6  # channels in their order


@pytest.mark.slow
def test_it_runs_on_a_hard_scene():
    done = subprocess.run(
        [
            *(sys.executable, "-W", "error", str(FOLDER / "detectors.py"), "--quick"),
            *(
                "--poses",
                "1",
                "--exposures",
                "2",
                "--only",
                "blunt",
                "--method",
                "lin2020",
                "--bounds",
                "0",
            ),
        ],
        check=True,
        capture_output=True,
        text=True,
        timeout=300,
        cwd=ROOT,
    )
    (one,) = json.loads(done.stdout)["conditions"]
    assert (one["group"], one["name"]) == ("hard", "blunt")
    found = one["methods"]["lin2020"]
    assert (found["pairs"], found["right"]) == (2, 1)
    assert abs(found["bias_px"]["along"]) < 2
    assert found["efficiency_mm"] is None


@pytest.mark.parametrize("axis", [(0.0, -1.0, 0.0), (0.6, 0.0, 0.8)])
def test_an_error_in_space_counts_along_the_needle_and_square_to_it(trials, axis):
    axis, true_mm = np.array(axis), np.array([1.0, 2.0, 3.0])
    covariance = 4.0 * np.outer(axis, axis) + 9.0 * (np.eye(3) - np.outer(axis, axis))
    answer = SimpleNamespace(tip_mm=true_mm - 0.5 * axis, covariance_mm2=covariance)
    place = trials._place(answer, SimpleNamespace(tip_mm=true_mm, axis=axis))
    np.testing.assert_allclose(place.error_mm, (-0.5, 0, 0), atol=1e-12)
    np.testing.assert_allclose(place.claimed_mm2, (4, 18))
    aside = np.cross(axis, (0.0, 0.0, 1.0))
    answer = SimpleNamespace(tip_mm=true_mm + aside, covariance_mm2=None)
    place = trials._place(answer, SimpleNamespace(tip_mm=true_mm, axis=axis))
    assert place.error_mm[0] == pytest.approx(0, abs=1e-12)
    assert place.norm_mm == pytest.approx(np.linalg.norm(aside))
    assert place.claimed_mm2 is None
