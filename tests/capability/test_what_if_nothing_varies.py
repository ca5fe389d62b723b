"""Are perfect, hopeless and too small data told apart from ordinary ones?"""

from __future__ import annotations

import json

import numpy as np
import pytest

from simtip.capability import (
    assess_accuracy,
    assess_agreement,
    assess_gauge,
    assess_repeatability,
    crossed,
    summarise_errors,
)
from simtip.capability.gauge_anova import analyse
from simtip.capability.limits import single_limits
from simtip.capability.regression import correlation_interval, regress
from simtip.capability.repeated_limits import repeated_limits

X = np.array([2.1, 4.3, 6.2, 8.4, 10.7])


def finite_json(data):
    return json.loads(json.dumps(data, allow_nan=False))


def test_a_constant_bias_has_limits_without_width():
    """0.3 cannot be written exactly: what its subtraction leaves is no scatter."""
    told = finite_json(assess_agreement(X + 0.3, X).to_dict())
    assert told["bias_mm"] == pytest.approx(0.3)
    assert told["sd_mm"] == 0
    assert told["loa_lower_mm"] == told["loa_upper_mm"] == told["bias_mm"]
    assert told["pearson_r_ci"] == pytest.approx([1, 1])
    assert told["normality_p"] is None
    assert told["heteroscedasticity_p"] is None
    assert told["pitman_morgan_p"] is None
    assert told["proportional_bias"]["slope"] == pytest.approx(0, abs=1e-12)


def test_identical_values_agree_perfectly():
    told = finite_json(assess_agreement(X, X).to_dict())
    assert (told["bias_mm"], told["sd_mm"]) == (0, 0)
    assert told["ccc"] == pytest.approx(1, abs=1e-12)
    accuracy = finite_json(assess_accuracy(X, X, steps=(np.diff(X), np.diff(X))).to_dict())
    assert (accuracy["max_abs_mm"], accuracy["mean_abs_ci_mm"]) == (0, [0, 0])
    assert accuracy["r2_step"] == pytest.approx(1)
    assert accuracy["r2_step_identity"] == 1


def test_equal_references_have_no_correlation_and_no_line():
    told = finite_json(assess_accuracy([2.1, 2.2, 1.9], [2, 2, 2]).to_dict())
    assert told["r2_cumulative"] is None
    assert told["linearity"] is None
    assert told["r2_step"] is None
    told = finite_json(assess_agreement([2.1, 2.2, 1.9], [2, 2, 2]).to_dict())
    assert told["pearson_r"] is told["ccc"] is None
    assert told["sd_mm"] > 0


def test_three_pairs_have_no_interval_of_their_correlation():
    assert correlation_interval(0.5, 3, 0.95) is None
    assert finite_json(assess_agreement([1, 2, 4], [1, 2, 3]).to_dict())["pearson_r_ci"] is None


def test_a_line_through_its_points_has_no_p_value():
    found = regress(3 * X + 0.1, X)
    assert found.slope == pytest.approx(3)
    assert found.slope_p is found.slope_ci is None
    assert regress([1.0, 2.0], [0.0, 1.0]).slope_p is None


def test_a_perfect_repetition_has_no_width():
    found = assess_repeatability([0.1 + 0.2, 0.3, 5, 5], ["a", "a", "b", "b"], tolerance=1)
    assert (found.sigma, found.p_t_percent) == (0, 0)
    # Whole pixels may hide a scatter: nothing is clear.
    assert all(verdict.met and not verdict.clear for verdict in found.verdicts)


def test_negative_components_count_as_0_and_are_named():
    # Operators and parts agree better than trials do by chance.
    trial = np.array([-1.0, 1.0])
    y = np.broadcast_to(trial, (3, 2, 2)) + np.arange(3)[:, None, None] * 1e-3
    found = assess_gauge(y)
    assert set(found.anova.components.negative) == {"part", "operator"}
    told = finite_json(found.to_dict())
    assert told["pv"] == told["av"] == 0
    assert told["ndc"] == 1
    assert sum("below 0" in note for note in told["notes"]) >= 2
    assert told["grr_percent_tv"] == 100
    # The interval of a part's share holds it, though nothing is left of the part.
    assert told["grr_percent_tv_ci"][1] == 100


def test_trials_that_never_differ_are_said_to_tell_nothing_of_interaction():
    y = np.repeat(np.array([[1.0, 1.1], [2.0, 2.3], [3.0, 3.1]])[:, :, None], 2, axis=2)
    told = finite_json(assess_gauge(y).to_dict())
    assert told["ev"] == 0
    assert any("cannot be tested" in note for note in told["notes"])
    assert not told["interaction_pooled"]
    additive = np.array([0.0, 5, 9])[:, None, None] + np.zeros((3, 2, 2))
    told = finite_json(assess_gauge(additive).to_dict())
    assert told["grr"] == 0
    assert told["ndc"] is None


def test_a_clear_interaction_is_kept():
    y = np.array([[1.0, 5], [5, 1], [3, 3]])[:, :, None] + np.array([0.0, 0.1])
    found = analyse(y)
    assert not found.pooled
    assert found.components.interaction > 1
    assert analyse(y, pool_above=-1).pooled


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (lambda: summarise_errors([1.0]), "at least 2"),
        (lambda: summarise_errors([1.0, np.inf]), "finite"),
        (lambda: single_limits([0.1, 0.2], level=1.0), "between 0 and 1"),
        (lambda: single_limits([0.1, 0.2], share=0), "between 0 and 1"),
        (lambda: repeated_limits([1, 2, 3], [1, 2, 4], "abc"), "two subjects"),
        (lambda: repeated_limits([1, 2, 3], [1, 2, 4], "aaa"), "two subjects"),
        (lambda: repeated_limits([1, 2, 3], [1, 2, 4], "aa"), "do not go with"),
        (lambda: assess_agreement([1, 2, 3], [1, 2, 4], true_value="varies"), "the subject"),
        (lambda: assess_agreement([1, 2], [1, 2]), "at least 3"),
        (lambda: assess_repeatability([1, 2], "ab"), "twice"),
        (lambda: assess_repeatability([1, 2], "aa", tolerance=0), "tolerance is 0"),
        (lambda: assess_repeatability([1, 2], "aa", multiplier=-6), "multiplier is -6"),
        (lambda: assess_gauge(np.zeros((3, 2, 2))), "all measured values are equal"),
        (lambda: assess_gauge(np.zeros((3, 1, 2))), "at least 2 operators, not 1"),
        (lambda: assess_gauge(np.zeros((3, 2))), "by part, operator and trial"),
        (lambda: crossed([1, 2, 3], "aab", "xyx"), "part b was measured 0 times by operator y"),
    ],
)
def test_what_cannot_be_worked_out_is_said(call, problem):
    with pytest.raises(ValueError, match=problem):
        call()
