"""Are p-values what other libraries and plain counting say, and is chance seldom a change?"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy import stats

from simtip.regress import exact
from simtip.regress.exact import holm, paired_t, rank_sum, signed_rank, stratified_rank_sum


@pytest.mark.parametrize("shift", [0.0, 1.0, 3.0])
def test_without_ties_ranks_say_what_scipy_does(shift):
    rng = np.random.default_rng(1)
    x, y = rng.normal(size=11), rng.normal(size=13) + shift
    wanted = stats.mannwhitneyu(x, y, method="exact").pvalue
    assert rank_sum(x, y).p == pytest.approx(wanted, rel=1e-9)
    pairs = y[:11] - x
    wanted = stats.wilcoxon(pairs, method="exact").pvalue
    assert signed_rank(pairs).p == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_with_ties_ranks_say_what_counting_every_division_does(seed):
    values = np.random.default_rng(seed).choice([0.0, 1, 2, 3, 4], 11, p=[0.4, 0.3, 0.1, 0.1, 0.1])
    x, y = values[:6], values[6:]
    ranks = stats.rankdata(np.concatenate([x, y]))
    sums = np.array([sum(c) for c in itertools.combinations(ranks, len(y))])
    observed = ranks[len(x) :].sum()
    wanted = 2 * min((sums <= observed).mean(), (sums >= observed).mean())
    assert rank_sum(x, y).p == pytest.approx(min(1, wanted))


def test_of_marks_ranks_are_fishers_test_and_signs_mcnemars():
    x, y = np.ones(12), np.r_[np.ones(5), np.zeros(7)]
    one_sided = stats.fisher_exact([[5, 7], [12, 0]], alternative="less").pvalue
    assert rank_sum(x, y).p == pytest.approx(2 * one_sided)
    differences = np.r_[-np.ones(9), np.ones(1), np.zeros(100)]
    assert signed_rank(differences).p == pytest.approx(stats.binomtest(1, 10).pvalue)


def test_strata_say_what_counting_every_division_of_each_does():
    rng = np.random.default_rng(3)
    strata = [(rng.integers(0, 3, 3) * 1.0, rng.integers(0, 3, 3) * 1.0) for _ in range(3)]
    sums, observed = np.zeros(1), 0.0
    for x, y in strata:
        ranks = stats.rankdata(np.concatenate([x, y]))
        own = [sum(c) for c in itertools.combinations(ranks, 3)]
        sums, observed = np.add.outer(sums, own).ravel(), observed + ranks[3:].sum()
    wanted = 2 * min((sums <= observed + 1e-9).mean(), (sums >= observed - 1e-9).mean())
    assert stratified_rank_sum(strata).p == pytest.approx(min(1, wanted))


@pytest.mark.parametrize("shift", [0.0, 0.4, 3.0])
def test_of_many_strata_fourier_transforms_say_what_sums_do(shift, monkeypatch):
    rng = np.random.default_rng(4)
    strata = [(rng.normal(size=9).round(1), rng.normal(shift, 1, 9).round(1)) for _ in range(12)]
    found = stratified_rank_sum(strata).p
    monkeypatch.setattr(exact, "FEW_STRATA", len(strata))
    assert found == pytest.approx(stratified_rank_sum(strata).p, rel=1e-5)


def test_many_values_are_as_the_normal_approximation_has_it():
    rng = np.random.default_rng(5)
    x, y = rng.normal(size=300), rng.normal(size=300) + 0.2
    assert rank_sum(x, y).p == pytest.approx(stats.mannwhitneyu(x, y).pvalue, rel=0.05)
    d = rng.normal(size=900) + 0.1
    assert signed_rank(d).p == pytest.approx(stats.wilcoxon(d).pvalue, rel=0.05)


def test_the_least_p_is_that_of_samples_apart():
    x, y = np.arange(4.0), np.arange(4.0) + 10
    told = rank_sum(x, y)
    assert told.p == pytest.approx(told.least_p)
    assert signed_rank(np.arange(1.0, 6)).least_p == pytest.approx(2**-4)


def test_equal_values_tell_nothing():
    assert rank_sum(np.full(5, 2.0), np.full(5, 2.0)).p == 1
    assert signed_rank(np.zeros(5)).p == 1
    assert stratified_rank_sum([(np.zeros(0), np.ones(3))]).least_p == 1


def test_a_shift_of_all_pairs_alike_is_judged_by_the_floor():
    alike = np.full(12, 0.1)
    wanted = stats.ttest_1samp(alike + 0.02 * stats.zscore(np.arange(12.0), ddof=1), 0).pvalue
    assert paired_t(alike, 0.02).p == pytest.approx(wanted)
    assert paired_t(np.array([0.1]), 0.02).p == 1


def test_holm_stops_at_the_first_that_is_not_significant():
    assert holm([0.0004, 0.2, 0.0002, 0.03], 0.001) == [False, False, True, False]
    assert holm([0.0003, 0.2, 0.0002, 0.03], 0.001) == [True, False, True, False]


DRAWS = 1000
KINDS = {
    "normal": lambda rng, shape: rng.normal(size=shape),
    "whole pixels": lambda rng, shape: np.round(rng.normal(size=shape)),
    "one pixel or the next": lambda rng, shape: (rng.random(shape) < 0.4) * 1.0,
    "seldom another": lambda rng, shape: (rng.random(shape) < 0.05) * 1.0,
    "heavy tails": lambda rng, shape: rng.standard_cauchy(shape),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("level", [0.05, 0.01])
def test_chance_is_called_a_change_no_more_often_than_stated(kind, level):
    rng = np.random.default_rng(7)
    draw = KINDS[kind]
    most = stats.binom.isf(1e-4, DRAWS, level)
    told = {"two": 0, "pairs": 0, "strata": 0}
    for _ in range(DRAWS):
        x, y = draw(rng, (3, 8)), draw(rng, (3, 8))
        told["two"] += rank_sum(x[0], y[0]).p <= level
        told["pairs"] += signed_rank((y - x).ravel()).p <= level
        told["strata"] += stratified_rank_sum(list(zip(x, y, strict=True))).p <= level
    assert max(told.values()) <= most


@pytest.mark.parametrize("kind", KINDS)
def test_pairs_with_the_floor_alarm_as_seldom_as_a_condition_may(kind):
    """Of a detector that draws lots itself; at a dozen pairs and the level of some 250 tests."""
    rng = np.random.default_rng(11)
    draw = KINDS[kind]
    differences = draw(rng, (200_000, 12)) - draw(rng, (200_000, 12))
    deviation = np.maximum(differences.std(axis=1, ddof=1), 0.02)
    t = np.abs(differences.mean(axis=1)) / deviation * np.sqrt(12)
    p = 2 * stats.t.sf(t, 11)
    assert (p <= 1e-3).sum() <= stats.binom.isf(1e-4, 200_000, 1e-3)
    assert (p <= 4e-6).sum() <= stats.binom.isf(1e-4, 200_000, 4e-6)
    assert paired_t(differences[0], 0.02).p == pytest.approx(p[0])
