"""Are shares of a total what their definitions say? Against all orders, and closed forms."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from simtip.budget.shares import grand_mean, rank, split, subsets


def game(causes, value):
    """Give a value's replicates, at one place, for every subset."""
    return {one: np.array([[value(one, r)] for r in range(4)]) for one in subsets(causes)}


def by_orders(values, causes):
    """Shapley's value as it is defined: the mean over all orders of what a cause adds."""
    total = np.zeros(causes)
    orders = list(itertools.permutations(range(causes)))
    for order in orders:
        there = frozenset()
        for cause in order:
            total[cause] += values[there | {cause}].mean() - values[there].mean()
            there |= {cause}
    return total / len(orders)


def test_shapley_is_the_mean_over_all_orders():
    rng = np.random.default_rng(2)
    values = {one: rng.normal(size=(6, 2)) for one in subsets(5)}
    found = split(values, 5, 0.95)
    assert found.shapley[:, 0] == pytest.approx(by_orders(values, 5))


def test_shares_and_the_rest_make_the_total_in_every_case():
    rng = np.random.default_rng(3)
    values = {one: rng.normal(size=(6, 2)) for one in subsets(6)}
    found = split(values, 6, 0.95)
    assert found.shapley[:, 0].sum() + found.rest[0] == pytest.approx(found.total[0])


def test_causes_that_add_have_one_share_however_it_is_asked():
    parts = [1.0, 2.0, 4.0]
    found = split(game(3, lambda one, _: 0.5 + sum(parts[k] for k in one)), 3, 0.95)
    for shares in (found.shapley, found.alone, found.removed):
        assert shares[:, 0] == pytest.approx(parts)


def test_a_square_of_a_sum_is_shared_with_its_cross_terms():
    """(a + b)^2: each gets its own square and half of 2 a b."""
    a, b = 3.0, 1.0
    found = split(game(2, lambda one, _: sum((a, b)[k] for k in one) ** 2), 2, 0.95)
    assert found.shapley[:, 0] == pytest.approx([a**2 + a * b, b**2 + a * b])
    assert found.alone[:, 0] == pytest.approx([9, 1])
    assert found.removed[:, 0] == pytest.approx([15, 7])


def test_what_does_nothing_gets_nothing():
    found = split(game(3, lambda one, r: float(1 in one) + 0.1 * r), 3, 0.95)
    assert found.shapley[[0, 2]] == pytest.approx(np.zeros((2, 3)))


def test_an_interval_is_students_over_replicates():
    values = {frozenset(): np.zeros((4, 1)), frozenset([0]): np.array([[1.0], [2], [3], [4]])}
    found = split(values, 1, 0.95)
    half = 3.182446305 * np.std([1, 2, 3, 4], ddof=1) / 2
    assert found.shapley[0] == pytest.approx([2.5, 2.5 - half, 2.5 * np.exp(half / 2.5)])
    assert found.total == pytest.approx([2.5, 2.5 * np.exp(-half / 2.5), 2.5 * np.exp(half / 2.5)])
    moved = {frozenset(): np.zeros((4, 1)), frozenset([0]): np.array([[-1.0], [0], [1], [2]])}
    found = split(moved, 1, 0.95)
    assert found.shapley[0] == pytest.approx([0.5, 0.5 - half, 0.5 + half])


def square(error):
    return (error**2).sum(axis=-1)


SQUARES = {
    "calibration": (lambda _, draw, own: square(draw + 0.1 * own), 3.03),
    "places": (lambda place, _, own: square(place + 0.1 * own), 3.03),
    "all": (lambda place, draw, own: square(place + draw + own), 9.0),
    "offset": (lambda _, draw, own: square([2, 0, 0] + 0.5 * draw + 0.3 * own), 5.02),
}
DIFFERENCES = {
    "share": (lambda place, draw, _: square(place + 0.5 * draw) - square(0.5 * draw), 3.0),
    "alone": (lambda _, draw, own: square(draw + 0.1 * own) - square(0.1 * own), 3.0),
}


@pytest.mark.parametrize("kind", [*SQUARES, *DIFFERENCES])
def test_intervals_of_squares_hold_the_mean(kind):
    """Square errors are skewed; a square of one normal number, drawn five times, is the worst."""
    made, true = (SQUARES | DIFFERENCES)[kind]
    rng, held, tries = np.random.default_rng(7), 0, 2000
    for _ in range(tries):
        errors = [rng.normal(size=shape) for shape in ((1, 15, 3), (5, 1, 3), (5, 15, 3))]
        _, low, high = grand_mean(made(*errors), 0.95, squares=kind in SQUARES)
        held += low <= true <= high
    assert 0.925 < held / tries < 0.985


@pytest.mark.parametrize(
    ("of_draws", "of_places", "own"), [(1, 0, 0), (0, 1, 0), (1, 1, 1), (0, 0, 1)]
)
def test_intervals_hold_the_truth_as_often_as_they_say(of_draws, of_places, own):
    """Other draws and other places; where neither is all, an interval is rather too wide."""
    rng, held, tries = np.random.default_rng(7), 0, 2000
    for _ in range(tries):
        values = (
            of_draws * rng.normal(size=(5, 1))
            + of_places * rng.normal(size=(1, 8))
            + own * rng.normal(size=(5, 8))
        )
        _, low, high = grand_mean(values, 0.95)
        held += low <= 0.0 <= high
    assert held / tries > 0.935
    if not own:
        assert held / tries == pytest.approx(0.95, abs=0.015)


def test_what_does_not_vary_has_no_width():
    assert grand_mean(np.full((3, 4), 2.0), 0.95).tolist() == [2, 2, 2]


def test_there_are_all_subsets():
    assert len(set(subsets(5))) == 2**5
    assert sum(len(one) for one in subsets(5)) == 5 * math.comb(4, 0) * 2**4


def test_the_largest_share_comes_first():
    assert rank([1.0, 3.0, -2.0]) == [1, 0, 2]
