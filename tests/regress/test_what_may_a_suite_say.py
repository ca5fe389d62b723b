"""Which suites are read, and how are others refused?"""

from __future__ import annotations

import pytest
import yaml
from small_suites import suite_file

from simtip.errors import InputError
from simtip.regress.chosen import Chosen
from simtip.regress.conditions import conditions_of
from simtip.regress.performed import planned
from simtip.regress.suite import read_suite, sweep_of
from simtip.sweep.campaign import Means
from simtip.sweep.plan import Plan


def test_the_standard_suite_has_what_the_page_says():
    suite = read_suite("standard")
    plans = [Plan(sweep_of(case, None), case.sweep.scene) for case in suite.cases]
    assert len(plans) == 23
    assert sum(len(conditions_of(plan)) for plan in plans) == 25
    assert sum(map(len, plans)) == 300


def test_conditions_are_the_trials_that_differ_in_their_repeat_alone(tmp_path):
    cases = [
        {
            "name": "many",
            "repeats": 3,
            "factors": {
                "needle.roll_deg": [0.0, 10.0],
                "lamps[0].power": [1.0, 1.5],
                "detect.threshold": [90, 100],
            },
        }
    ]
    (case,) = read_suite(suite_file(tmp_path, cases=cases)).cases
    plan = Plan(sweep_of(case, None), case.sweep.scene)
    found = conditions_of(plan)
    assert sorted(number for one in found for number in one.trials) == list(range(len(plan)))
    assert len({one.name for one in found}) == len(found) == 8
    for one in found:
        trials = [plan.trial(number) for number in one.trials]
        assert [trial.repeat for trial in trials] == [0, 1, 2]
        assert len({str(trial.factors) for trial in trials}) == 1


def test_sampled_points_are_conditions(tmp_path):
    cases = [
        {
            "name": "spread",
            "repeats": 2,
            "factors": {"lamps[0].power": {"from": 0.5, "to": 2.0}},
            "design": {"kind": "sobol", "points": 4, "seed": 1},
        }
    ]
    (case,) = read_suite(suite_file(tmp_path, cases=cases)).cases
    found = conditions_of(Plan(sweep_of(case, None), case.sweep.scene))
    assert [one.trials for one in found] == [(0, 1), (2, 3), (4, 5), (6, 7)]


def test_a_case_named_as_a_condition_of_another_is_refused(tmp_path):
    """Results are kept by that name: one of the two would be lost."""
    cases = [
        {"name": "lamps: lamps[0].power=0.8"},
        {"name": "lamps", "factors": {"lamps[0].power": [0.8, 1.2]}},
    ]
    suite = read_suite(suite_file(tmp_path, cases=cases))
    means = Means(1, None, None, tmp_path / "cache", "20GB")
    with pytest.raises(InputError, match="have the same name, 'lamps: lamps") as caught:
        planned(suite.cases, Chosen(), means)
    assert str(tmp_path / "suite.yaml") in str(caught.value)
    planned(suite.cases[:1], Chosen(), means)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"tolerance": {"bias_px": -1.0}}, "tolerance.bias_px"),
        ({"tolerance": {"bias": 1.0}}, "tolerance.bias"),
        ({"cases": []}, "cases"),
        ({"cases": [{"name": "a"}, {"name": "a"}]}, "'a'"),
        ({"cases": [{"name": "a", "detectors": ["lin2020"]}]}, "detectors"),
        ({"cases": [{"name": "a", "repeats": 1}]}, "repeats"),
        ({"cases": [{"name": "a", "factors": {"lamps[0].powr": [1.0]}}]}, None),
        ({"repeats": 0}, "repeats"),
        ({"scene": "none.yaml"}, "none.yaml"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, change, said):
    path = suite_file(tmp_path, **change)
    if said is None:  # found when it is planned, as of any sweep
        (case,) = read_suite(path).cases
        with pytest.raises(InputError, match="powr"):
            Plan(sweep_of(case, None), case.sweep.scene)
        return
    with pytest.raises(InputError) as caught:
        read_suite(path)
    assert said in str(caught.value)
    assert yaml.safe_load(path.read_text())["name"] == "small"
