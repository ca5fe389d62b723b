"""Is what is said to be seen nine times of ten seen so often, and what is half of it seldom?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip.regress.exact import rank_sum, signed_rank, stratified_rank_sum
from simtip.regress.power import (
    least_loss,
    least_pooled_loss,
    least_ratio,
    least_shift,
    power_of_all,
    power_of_condition,
)

DRAWS = 300
RNG = np.random.default_rng(30)


def share(p_values) -> float:
    return float(np.mean(p_values))


@pytest.mark.slow
@pytest.mark.parametrize(("n", "alpha"), [(12, 1e-3), (12, 5e-6), (30, 5e-6)])
def test_a_shift_of_one_condition(n, alpha):
    least = least_shift(n, alpha)

    def seen(shift):
        return share(
            [
                rank_sum(RNG.normal(size=n), RNG.normal(size=n) + shift).p <= alpha
                for _ in range(DRAWS)
            ]
        )

    assert seen(least) > 0.75
    assert seen(0.5 * least) < 0.4
    assert seen(1.3 * least) > 0.95


@pytest.mark.slow
def test_a_spread_of_all_conditions():
    n, strata, alpha = 12, 10, 1e-4
    least = least_ratio(n, strata, alpha)

    def seen(ratio):
        found = []
        for _ in range(100):
            x, y = np.abs(RNG.normal(size=(2, strata, n)))
            told = stratified_rank_sum(list(zip(x, ratio * y, strict=True)))
            found.append(told.p <= alpha)
        return share(found)

    assert seen(least) > 0.75
    assert seen(1 + 0.5 * (least - 1)) < 0.6


def test_a_loss_of_one_condition_and_of_all():
    n, alpha = 12, 1e-3
    least = least_loss(n, alpha)
    lost = RNG.random((DRAWS, n)) < least
    seen = share([rank_sum(np.ones(n), 1.0 - one).p <= alpha for one in lost])
    assert seen == pytest.approx(0.9, abs=0.06)
    least = least_pooled_loss(300, alpha)
    lost = RNG.random((DRAWS, 300)) < least
    assert share([signed_rank(-1.0 * one).p <= alpha for one in lost]) == pytest.approx(
        0.9, abs=0.06
    )


def test_where_nothing_can_be_seen_it_is_said():
    assert least_shift(4, 1e-3) is None
    assert least_ratio(4, 1, 1e-3) is None
    assert least_loss(4, 1e-3) is None
    assert least_pooled_loss(5, 1e-3) is None
    assert least_ratio(2, 1, 1e-3) is None
    assert set(power_of_all(12, 0, 1, 0.001, 0.004).values()) == {None}


def test_all_conditions_together_see_more_than_one():
    one = power_of_condition(12, 200, 0.001)
    together = power_of_all(12, 25, 13, 0.001, 0.004)
    assert together["shift_sigma"] < 0.5 < one["shift_sigma"]
    assert together["loss"] < 0.06 < one["loss"]
