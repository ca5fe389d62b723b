"""Which changes of made-up samples are called what: worse, better, moved, the same, untold?"""

from __future__ import annotations

import numpy as np
import pytest
from small_suites import suite_file

from simtip.regress.change import (
    BETTER,
    DETECTION,
    MOVED,
    OUTLIERS,
    SAME,
    SHIFT,
    SPREAD,
    UNTOLD,
    WORSE,
)
from simtip.regress.compared import compare
from simtip.regress.conditions import conditions_of, sample_of
from simtip.regress.quantities import Pair
from simtip.regress.sample import Sample
from simtip.regress.suite import read_suite
from simtip.regress.tolerance import Tolerance
from simtip.regress.words import said_of
from simtip.sweep.plan import Plan

UP = np.array([[0.0, -1.0], [0.0, -1.0]])
N = 12


def sample(errors, found=None, axis=UP) -> Sample:
    errors = np.asarray(errors, dtype=float)
    found = ~np.isnan(errors).any(axis=(1, 2)) if found is None else found
    return Sample(found, errors, axis)


def noise(seed: int, sd: float = 0.1, n: int = N) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, sd, (n, 2, 2))


def compared(before: list[Sample], after: list[Sample], *, paired: bool = True):
    pairs = {
        f"case {k}": Pair.of(x, y, paired=paired)
        for k, (x, y) in enumerate(zip(before, after, strict=True))
    }
    found = compare(pairs, Tolerance(), paired=paired)
    return found, said_of(found, pairs, {}, Tolerance())


def states(found, kind: str) -> set[str]:
    return {one.state for _, one in found.changes if one.kind == kind}


def test_what_is_equal_is_the_same():
    samples = [sample(noise(k) + 1) for k in range(5)]
    found, lines = compared(samples, samples)
    assert found.state == SAME
    assert lines == []


@pytest.mark.parametrize("paired", [True, False])
@pytest.mark.parametrize(
    ("bias", "shift", "state"),
    [(0.0, 1.0, WORSE), (1.0, -0.9, BETTER), (-0.5, 1.0, MOVED), (0.0, 0.01, SAME)],
)
def test_a_shift_is_judged_by_the_distance_from_the_truth(bias, shift, state, paired):
    before = [sample(noise(k, 0.02) + bias) for k in range(8)]
    after = [
        sample(noise(k if paired else 100 + k, 0.02) + bias + shift * np.array([1.0, 1.0]))
        for k in range(8)
    ]
    found, _ = compared(before, after, paired=paired)
    assert found.state == state
    assert states(found, SPREAD) == {SAME}


def test_one_condition_that_moved_is_named_alone():
    before = [sample(noise(k)) for k in range(8)]
    after = [sample(noise(k) + (1.0 if k == 3 else 0.0)) for k in range(8)]
    _, lines = compared(before, after)
    (line,) = [one for one in lines if one.kind == SHIFT and one.where]
    assert line.where == ("case 3",)
    assert line.text.startswith("tip moved in case 3 (")


def test_a_small_shift_that_all_have_in_common_is_seen():
    before = [sample(noise(k) + 0.2) for k in range(25)]
    after = [sample(noise(100 + k) + 0.2 + np.array([0.06, 0.0])) for k in range(25)]
    found, lines = compared(before, after, paired=False)
    assert all(one.state == SAME for own in found.conditions.values() for one in own)
    assert found.state == WORSE
    assert lines[0].kind == SHIFT


def test_a_common_shift_to_the_truth_here_and_from_it_there_is_neither():
    bias = [1.0 if k % 2 else -1.0 for k in range(24)]
    before = [sample(noise(k) + bias[k]) for k in range(24)]
    after = [sample(noise(100 + k) + bias[k] + 0.06) for k in range(24)]
    found, _ = compared(before, after, paired=False)
    assert {one.state for one in found.pooled if one.kind == SHIFT} == {MOVED}


def test_views_that_moved_differently_are_told_apart():
    before = [sample(noise(k)) for k in range(6)]
    by = np.array([[0.5, 0.0], [0.0, -0.25]])
    _, lines = compared(before, [sample(noise(k) + by) for k in range(6)])
    text = "(+0.50, +0.00) px in the left view and (+0.00, -0.25) px in the right one"
    assert text in lines[0].text


def test_whole_pixels_without_any_scatter_are_compared():
    before = [sample(np.full((N, 2, 2), 3.0)) for _ in range(4)]
    after = [sample(np.full((N, 2, 2), 4.0)) for _ in range(4)]
    for paired in (True, False):
        found, _ = compared(before, after, paired=paired)
        assert found.state == WORSE
        assert states(found, SPREAD) == {SAME}


@pytest.mark.slow
def test_more_scatter_is_spread_and_no_shift():
    before = [sample(noise(k)) for k in range(25)]
    after = [sample(noise(100 + k, 0.25)) for k in range(25)]
    for paired in (True, False):
        found, lines = compared(before, after, paired=paired)
        assert WORSE in states(found, SPREAD)
        assert states(found, SHIFT) <= {SAME, UNTOLD}
        assert any("spread of all conditions" in line.text for line in lines)
        found, _ = compared(after, before, paired=paired)
        assert found.state == BETTER


def test_scatter_below_what_counts_is_left_alone():
    before = [sample(noise(k, 0.001)) for k in range(25)]
    after = [sample(noise(100 + k, 0.004)) for k in range(25)]
    found, _ = compared(before, after, paired=False)
    assert found.state == SAME


def lost(one: Sample, which) -> Sample:
    errors = one.error_px.copy()
    errors[which] = np.nan
    return sample(errors)


@pytest.mark.parametrize("paired", [True, False])
def test_a_condition_that_finds_nothing_any_more_is_named(paired):
    before = [sample(noise(k)) for k in range(25)]
    after = [lost(one, slice(None)) if k == 7 else one for k, one in enumerate(before)]
    found, lines = compared(before, after, paired=paired)
    assert found.state == WORSE
    (line,) = [one for one in lines if one.where]
    assert line.where == ("case 7",)
    assert "12 of 12 before, 0 of 12 now" in line.text


def test_one_tip_in_twenty_lost_is_seen_and_counted():
    before = [sample(noise(k)) for k in range(25)]
    after = [lost(one, [k % N] if k % 2 == 0 else []) for k, one in enumerate(before)]
    _, lines = compared(before, after)
    assert lines[0].state == WORSE
    assert lines[0].text.startswith("detections lost: 4.3 % of 300 pairs (13 lost, 0 gained)")


def test_as_many_gained_as_lost_is_no_loss():
    before = [lost(sample(noise(k)), [0]) for k in range(25)]
    after = [lost(sample(noise(k)), [1]) for k in range(25)]
    found, _ = compared(before, after)
    assert states(found, DETECTION) <= {SAME}


def test_a_tip_lost_in_one_view_counts_where_there_was_no_match():
    one = sample(noise(1), found=np.zeros(N, np.bool_))
    blind = one.error_px.copy()
    blind[:, 0] = np.nan
    found, lines = compared([one], [Sample(one.found, blind, UP)])
    assert WORSE in states(found, DETECTION)
    assert any("12 of 24 tips in images" in line.text for line in lines)


def test_strays_are_called_so_and_neither_shift_nor_spread():
    before = [sample(noise(k)) for k in range(25)]
    after = []
    for k, one in enumerate(before):
        errors = one.error_px.copy()
        if k % 2 == 0:
            errors[k % N] += 40
        after.append(sample(errors))
    for paired in (True, False):
        found, _ = compared(before, after, paired=paired)
        assert [one.state for one in found.pooled if one.kind == OUTLIERS] == [WORSE]
        assert states(found, OUTLIERS) <= {WORSE, UNTOLD, SAME}  # of one tip: not none
        assert states(found, SHIFT) == states(found, SPREAD) == {SAME}


def test_the_side_effect_of_a_large_shift_is_no_change_of_its_own():
    """Along a row of pixels is not quite along the needle."""
    axis = np.array([[0.035, -1.0], [0.035, -1.0]]) / np.hypot(0.035, 1.0)
    before = [sample(np.full((N, 2, 2), [0.4, -8.0]), axis=axis) for _ in range(3)]
    after = [sample(np.full((N, 2, 2), [0.4, -7.0]), axis=axis) for _ in range(3)]
    found, _ = compared(before, after)
    assert found.state == BETTER


def test_too_few_repeats_are_no_alarm_and_no_all_clear_on_the_same_images():
    before = [sample(noise(k, 0.2, n=3)) for k in range(2)]
    after = [sample(noise(k, 0.2, n=3) + 0.9 + noise(50 + k, 0.05, n=3)) for k in range(2)]
    found, _ = compared(before, after)
    assert found.state == UNTOLD


def test_nothing_to_compare_is_nothing_said():
    found, lines = compared([], [])
    assert found.state == SAME
    assert lines == []


@pytest.mark.parametrize("far", [1, 3, 5, 6, 7])
def test_tips_far_off_in_one_condition_of_the_same_images_are_not_called_none(far):
    before = [sample(noise(k) + 8) for k in range(25)]
    strayed = before[3].error_px.copy()
    strayed[:far, 0] += [100, 0]
    found, lines = compared(before, [*before[:3], sample(strayed), *before[4:]])
    assert found.state == UNTOLD
    assert any("case 3" in line.where for line in lines)


def test_many_tips_far_off_in_one_condition_are_worse():
    before = [sample(noise(k, n=100)) for k in range(3)]
    strayed = before[1].error_px.copy()
    strayed[:40, 0] += [100, 0]
    found, lines = compared(before, [before[0], sample(strayed), before[2]], paired=False)
    assert states(found, OUTLIERS) == {WORSE, SAME}
    assert any(
        line.where == ("case 1",) and "0.0 % of pairs before, 40.0 % now" in line.text
        for line in lines
    )


@pytest.mark.parametrize("paired", [True, False])
def test_an_error_that_is_gone_across_a_slanted_needle_is_better(paired):
    along, across = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2)
    axis = np.array([along, along])
    before = [sample(noise(k) + along + across, axis=axis) for k in range(10)]
    after = [
        sample(noise(k if paired else 100 + k) + along, axis=axis)  # farther from 0 in v
        for k in range(10)
    ]
    found, lines = compared(before, after, paired=paired)
    assert found.state == BETTER
    assert {line.state for line in lines} == {BETTER}


@pytest.mark.parametrize(("invented", "state"), [(12, WORSE), (0, BETTER)])
def test_a_tip_found_where_none_is_in_view_is_worse(invented, state):
    hidden, visible = noise(1), noise(1) + 50
    hidden[:, 1] = np.nan
    both = [Sample(np.zeros(N, bool), errors, UP, (True, False)) for errors in (hidden, visible)]
    before, after = both if invented else both[::-1]
    found, lines = compared([before], [after])
    assert states(found, DETECTION) - {SAME} == {state}
    counts = "12 before, 24 now" if invented else "24 before, 12 now"
    assert any(counts in line.text and "out of view" in line.text for line in lines)


def test_what_is_in_view_is_told_by_the_scene(tmp_path):
    suite = read_suite(
        suite_file(
            tmp_path,
            cases=[
                {"name": "in view"},
                {"name": "out", "base": {"rig.right.roi": [983, 555, 100, 150]}},
            ],
        )
    )
    seen = []
    for case in suite.cases:
        plan = Plan(case.sweep.spec, case.sweep.scene, (), case.name)
        one = conditions_of(plan)[0]
        rows = {number: failed_row() for number in one.trials}
        seen.append(sample_of(plan, one, rows).in_view)
    assert seen == [(True, True), (True, False)]


def failed_row() -> dict[str, object]:
    errors = {f"{side}_error_{axis}_px": None for side in ("left", "right") for axis in "uv"}
    return {"status": "no_needle", **errors}
