"""Which trials does a plan have: values, order, seeds, points; each found by its number alone?"""

from itertools import product

import numpy as np
import pytest
import yaml
from small_sweeps import scene_file

from simtip.sweep.levels import mixed_radix, points, values_of
from simtip.sweep.plan import Plan
from simtip.sweep.spec import RangeSpec, SampledSpec
from simtip.sweep.sweep_file import read_sweep


def plan_of(folder, **said):
    scene_file(folder)
    file = folder / "sweep.yaml"
    file.write_text(yaml.safe_dump({"scene": "scene.yaml", **said}, sort_keys=False))
    source = read_sweep(file)
    return Plan(source.spec, source.scene)


GRID = {
    "factors": {
        "detect.threshold": [80, 90, 100],
        "needle.roll_deg": [0.0, 30.0],
        "lamps[0].power": [1.0, 2.0],
    },
    "repeats": 2,
    "detectors": ["lin2020", "subpixel"],
}


def test_a_grid_has_every_combination_once(tmp_path):
    plan = plan_of(tmp_path, **GRID)
    seen = [
        (*trial.factors.values(), trial.repeat, trial.measuring.label)
        for trial in map(plan.trial, range(len(plan)))
    ]
    expected = product([0.0, 30.0], [1.0, 2.0], [80, 90, 100], [0, 1], ["lin2020", "subpixel"])
    assert len(seen) == len(plan) == 48
    assert set(seen) == set(expected)


def test_trials_of_one_render_stand_together(tmp_path):
    plan = plan_of(tmp_path, **GRID)
    rolls = [plan.trial(k).factors["needle.roll_deg"] for k in range(len(plan))]
    assert plan.block == 24
    assert rolls == [0.0] * 24 + [30.0] * 24


def test_a_parameter_goes_to_the_detectors_that_have_it(tmp_path):
    plan = plan_of(tmp_path, **GRID)
    taken = {
        (trial.measuring.label, trial.measuring.parameters.get("threshold"))
        for trial in map(plan.trial, range(len(plan)))
    }
    assert taken == {("lin2020", 80), ("lin2020", 90), ("lin2020", 100), ("subpixel", None)}


def test_keys_differ_and_do_not_depend_on_what_else_is_asked_for(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    few, many = (
        plan_of(tmp_path / "a", **GRID),
        plan_of(
            tmp_path / "b",
            **{**GRID, "factors": {**GRID["factors"], "lamps[0].power": [1.0, 2.0, 3.0]}},
        ),
    )
    of_few = {few.key(few.trial(k)) for k in range(len(few))}
    of_many = {many.key(many.trial(k)) for k in range(len(many))}
    assert len(of_few) == len(few)
    assert of_few < of_many


def test_zipped_fields_vary_together(tmp_path):
    plan = plan_of(tmp_path, zipped=[{"lamps[0].power": [1.0, 2.0], "lamps[1].power": [3.0, 4.0]}])
    assert [tuple(plan.trial(k).factors.values()) for k in (0, 1)] == [(1.0, 3.0), (2.0, 4.0)]


def test_a_kind_may_change_alone(tmp_path):
    plan = plan_of(tmp_path, factors={"needle.tip.kind": ["cone", "bevel"]})
    kinds = [plan.scenes.with_values(plan.trial(k).values).needle.tip.kind for k in (0, 1)]
    assert kinds == ["cone", "bevel"]


@pytest.mark.parametrize(
    ("given", "whole", "expected"),
    [
        ({"from": 0, "to": 1, "count": 5}, False, [0, 0.25, 0.5, 0.75, 1]),
        ({"from": 0.1, "to": 0.5, "step": 0.1}, False, [0.1, 0.2, 0.3, 0.4, 0.5]),
        ({"from": 1, "to": 100, "count": 3, "log": True}, False, [1, 10, 100]),
        ({"from": 60, "to": 120, "step": 25}, True, [60, 85, 110]),
        ({"from": 1, "to": 3, "count": 9}, True, [1, 2, 3]),
    ],
)
def test_ranges(given, whole, expected):
    assert list(values_of(RangeSpec.model_validate(given), whole=whole)) == expected


@pytest.mark.parametrize("kind", ["random", "sobol", "latin_hypercube"])
def test_points_fill_the_space_and_are_the_same_again(kind):
    design = SampledSpec(kind=kind, points=64, seed=3)
    spread = points(design, 3)
    assert spread.shape == (64, 3)
    assert (spread >= 0).all()
    assert (spread < 1).all()
    assert np.array_equal(spread, points(design, 3))
    assert not np.array_equal(spread, points(design.model_copy(update={"seed": 4}), 3))
    if kind != "random":  # each quarter of every axis has its share
        counts = [np.histogram(column, 4, (0, 1))[0] for column in spread.T]
        assert (np.array(counts) == 16).all()


def test_more_points_begin_with_the_fewer():
    for kind in ("random", "sobol"):
        few = points(SampledSpec(kind=kind, points=10), 2)
        assert np.array_equal(points(SampledSpec(kind=kind, points=50), 2)[:10], few)


def test_sampled_values_lie_within_and_lists_are_sampled_too(tmp_path):
    plan = plan_of(
        tmp_path,
        factors={
            "sensor.exposure_s": {"from": 0.01, "to": 0.1, "log": True},
            "detect.threshold": {"from": 60, "to": 63},
            "needle.tip.kind": ["cone", "bevel"],
        },
        design={"kind": "sobol", "points": 32},
    )
    trials = [plan.trial(k) for k in range(len(plan))]
    exposures = np.array([t.factors["sensor.exposure_s"] for t in trials])
    assert len(trials) == 32
    assert (exposures >= 0.01).all()
    assert (exposures <= 0.1).all()
    assert np.median(exposures) == pytest.approx(np.sqrt(0.01 * 0.1), rel=0.2)
    assert {t.factors["detect.threshold"] for t in trials} == {60, 61, 62, 63}
    assert {t.factors["needle.tip.kind"] for t in trials} == {"cone", "bevel"}


def test_the_light_is_rendered_for_the_most_demanding_levels(tmp_path):
    plan = plan_of(
        tmp_path, factors={"lamps[0].power": [0.5, 2.0, 1.0]}, base={"render.noise": 0.5}
    )
    references = {plan.reference(plan.trial(k)).lamps[0].power for k in range(3)}
    assert references == {2.0}


def test_digits():
    sizes = (3, 1, 4, 2)
    seen = [mixed_radix(number, sizes) for number in range(24)]
    assert seen == [list(digits) for digits in product(*map(range, sizes))]


@pytest.mark.slow
def test_ten_thousand_million_trials_cost_nothing_to_plan(tmp_path):
    plan = plan_of(
        tmp_path,
        factors={
            "lamps[0].power": {"from": 1.0, "to": 2.0, "count": 10000},
            "lamps[1].power": {"from": 1.0, "to": 2.0, "count": 1000},
        },
        repeats=1000,
    )
    assert len(plan) == 10**10
    assert plan.trial(10**10 - 1).factors == {"lamps[0].power": 2.0, "lamps[1].power": 2.0}
