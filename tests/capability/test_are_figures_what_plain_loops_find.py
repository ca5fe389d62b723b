"""Do figures agree with plain loops over the data, and with SciPy's own functions?"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from simtip.capability import (
    assess_accuracy,
    assess_agreement,
    assess_gauge,
    assess_repeatability,
    crossed,
    summarise_errors,
)
from simtip.capability.accuracy import identity_r2
from simtip.capability.concordance import concordance
from simtip.capability.gauge_anova import analyse
from simtip.capability.interval import Interval, mover
from simtip.capability.limits import single_limits
from simtip.capability.mean_squares import (
    MeanSquare,
    difference_interval,
    ratio_interval,
    sum_interval,
)
from simtip.capability.regression import breusch_pagan, regress
from simtip.capability.repeated_limits import repeated_limits
from simtip.capability.variance_components import percent_of_total

EXACT = {"rel": 1e-10, "abs": 1e-12}


@pytest.fixture
def pairs():
    rng = np.random.default_rng(5)
    x = rng.uniform(2, 28, 23)
    return 0.29 + 1.01 * x + rng.normal(0, 0.2, 23), x


def test_errors_are_summed_up_as_a_loop_does(pairs):
    y, x = pairs
    e = [b - a for a, b in zip(x, y, strict=True)]
    n, found = len(e), summarise_errors(y - x)
    assert found.mean == pytest.approx(sum(e) / n, **EXACT)
    assert found.mean_abs == pytest.approx(sum(map(abs, e)) / n, **EXACT)
    assert found.rms == pytest.approx(math.sqrt(sum(v * v for v in e) / n), **EXACT)
    assert found.max_abs == max(abs(v) for v in e)
    t = stats.ttest_1samp(e, 0).confidence_interval(0.95)
    assert found.mean_ci.to_list() == pytest.approx([t.low, t.high], **EXACT)
    assert found.rms_ci.low < found.rms < found.rms_ci.high
    assert found.mean_abs_ci.low < found.mean_abs < found.mean_abs_ci.high


def test_the_line_is_scipys_and_its_intervals_are_students(pairs):
    y, x = pairs
    line, found = stats.linregress(x, y - x), regress(y - x, x, 0.9)
    t = stats.t.ppf(0.95, len(x) - 2)
    assert found.slope == pytest.approx(line.slope, **EXACT)
    assert found.slope_p == pytest.approx(line.pvalue, rel=1e-8)
    half = t * line.stderr
    assert found.slope_ci.to_list() == pytest.approx([line.slope - half, line.slope + half])
    half = t * line.intercept_stderr
    ends = [line.intercept - half, line.intercept + half]
    assert found.intercept_ci.to_list() == pytest.approx(ends)
    p = 2 * stats.t.sf(abs(line.intercept / line.intercept_stderr), len(x) - 2)
    assert found.intercept_p == pytest.approx(p, rel=1e-8)


def test_r_squared_is_told_by_its_definitions(pairs):
    y, x = pairs
    steps = np.diff(y), np.diff(x)
    found = assess_accuracy(y, x, steps=steps)
    assert found.r2_cumulative == pytest.approx(stats.pearsonr(x, y).statistic ** 2, **EXACT)
    assert found.r2_step == pytest.approx(stats.pearsonr(*steps).statistic ** 2, **EXACT)
    mean = sum(y) / len(y)
    sse = sum((b - a) ** 2 for a, b in zip(x, y, strict=True))
    sst = sum((b - mean) ** 2 for b in y)
    assert found.r2_cumulative_identity == pytest.approx(1 - sse / sst, **EXACT)
    assert found.r2_step_identity == pytest.approx(identity_r2(*steps), **EXACT)
    assert found.steps.max_abs == pytest.approx(np.abs(np.diff(y - x)).max(), **EXACT)
    # A constant bias leaves r^2 as it is, and lowers the other.
    moved = assess_accuracy(y + 5, x)
    assert moved.r2_cumulative == pytest.approx(found.r2_cumulative, **EXACT)
    assert moved.r2_cumulative_identity < found.r2_cumulative_identity - 0.1


def test_agreement_of_single_pairs_is_scipys(pairs):
    y, x = pairs
    found = assess_agreement(y, x, level=0.9)
    d, z = y - x, stats.norm.ppf(0.975)
    sd = d.std(ddof=1)
    assert found.limits.lower == pytest.approx(d.mean() - z * sd, **EXACT)
    assert found.limits.upper == pytest.approx(d.mean() + z * sd, **EXACT)
    k = stats.nct.ppf([0.05, 0.95], 22, z * math.sqrt(23)) / math.sqrt(23)
    assert found.limits.upper_ci.to_list() == pytest.approx(list(d.mean() + k * sd))
    assert found.limits.lower_ci.to_list() == pytest.approx(list(d.mean() - k[::-1] * sd))
    r = stats.pearsonr(y, x)
    interval = r.confidence_interval(0.9)
    assert found.pearson_r == pytest.approx(r.statistic, **EXACT)
    assert found.pearson_r_ci.to_list() == pytest.approx([interval.low, interval.high])
    assert found.normality_p == pytest.approx(stats.shapiro(d).pvalue)


def test_proportional_bias_is_pitmans_and_morgans_test(pairs):
    y, x = pairs
    found = assess_agreement(y, x)
    # Equal variances are uncorrelated sum and difference.
    p = stats.pearsonr(y - x, y + x).pvalue
    assert found.to_dict()["pitman_morgan_p"] == pytest.approx(p, rel=1e-8)
    assert found.proportional.slope == pytest.approx(stats.linregress((y + x) / 2, y - x).slope)


def test_breusch_and_pagans_test_is_n_r_squared():
    rng = np.random.default_rng(2)
    x = rng.uniform(1, 5, 40)
    e = rng.normal(0, x)
    design = np.column_stack([np.ones(40), x])
    fit, *_ = np.linalg.lstsq(design, e**2, rcond=None)
    r2 = 1 - ((e**2 - design @ fit) ** 2).sum() / ((e**2 - (e**2).mean()) ** 2).sum()
    assert breusch_pagan(e, x) == pytest.approx(stats.chi2.sf(40 * r2, 1), rel=1e-8)


def test_concordance_is_one_less_the_squared_distance_from_the_identity(pairs):
    y, x = pairs
    n = len(x)
    near = sum((b - a) ** 2 for a, b in zip(x, y, strict=True)) / n
    far = x.var() + y.var() + (x.mean() - y.mean()) ** 2
    found = concordance(y, x)
    assert found.ccc == pytest.approx(1 - near / far, **EXACT)
    assert found.ccc == pytest.approx(found.bias_correction * stats.pearsonr(x, y).statistic)
    # Lin's standard error of Z, as printed in Lin (2000), term by term.
    r, c = stats.pearsonr(x, y).statistic, found.ccc
    u2 = (y.mean() - x.mean()) ** 2 / (y.std() * x.std())
    variance = (
        (1 - r**2) * c**2 / ((1 - c**2) * r**2)
        + 2 * c**3 * (1 - c) * u2 / (r * (1 - c**2) ** 2)
        - c**4 * u2**2 / (2 * r**2 * (1 - c**2) ** 2)
    ) / (n - 2)
    ends = np.tanh(math.atanh(c) + np.array([-1.96, 1.96]) * math.sqrt(variance))
    assert found.ccc_ci.to_list() == pytest.approx(list(ends), abs=1e-5)


@pytest.mark.parametrize("true_value", ["varies", "constant"])
def test_repeated_limits_of_one_pair_more_are_those_of_a_loop(true_value):
    rng = np.random.default_rng(8)
    counts = [2, 3, 4, 3, 2]
    who = [k for k, count in enumerate(counts) for _ in range(count)]
    x = rng.normal(10, 3, 5)[who] + rng.normal(0, 0.3, 14)
    y = x + rng.normal(0.3, 0.2, 14)
    found = repeated_limits(y, x, who, true_value=true_value)
    inside = {}
    for name, values in {"d": y - x, "x": x, "y": y}.items():
        total = 0.0
        for part in set(who):
            mine = [v for v, w in zip(values, who, strict=True) if w == part]
            total += sum((v - sum(mine) / len(mine)) ** 2 for v in mine)
        inside[name] = total / (14 - 5)
    d = y - x
    if true_value == "varies":
        f = stats.f_oneway(*[d[np.array(who) == k] for k in range(5)]).statistic
        divisor = (14 - sum(c * c for c in counts) / 14) / 4
        within, between = inside["d"], (f - 1) * inside["d"] / divisor
    else:
        means = [d[np.array(who) == k].mean() for k in range(5)]
        within = inside["x"] + inside["y"]
        between = np.var(means, ddof=1) - within * sum(1 / c for c in counts) / 5
    assert found.bias == pytest.approx(d.mean(), **EXACT)
    assert found.within_sd == pytest.approx(math.sqrt(within), **EXACT)
    assert found.between_sd == pytest.approx(math.sqrt(max(between, 0)), **EXACT)
    assert found.sd == pytest.approx(math.sqrt(within + between), **EXACT)
    assert bool(found.notes) == (between < 0)


@pytest.mark.parametrize("true_value", ["varies", "constant"])
def test_intervals_of_repeated_limits_are_zous_sum_of_squares(true_value):
    rng = np.random.default_rng(12)
    who = np.repeat(np.arange(7), 4)
    x = rng.normal(0, 0.4, 28)
    y = x + rng.normal(0, 1, 7)[who] + rng.normal(0, 0.4, 28)
    found = repeated_limits(y, x, who.tolist(), true_value=true_value)

    def within(v):
        return sum(((v[who == k] - v[who == k].mean()) ** 2).sum() for k in range(7)) / 21

    means = [(y - x)[who == k].mean() for k in range(7)]
    terms = [(np.var(means, ddof=1), 6)]
    terms += [(0.75 * within(v), 21) for v in ((y - x,) if true_value == "varies" else (x, y))]
    total = sum(term for term, _ in terms)

    def end(p):
        far = [term * (freedom / stats.chi2.ppf(p, freedom) - 1) for term, freedom in terms]
        return total + math.copysign(math.sqrt(sum(v**2 for v in far)), 0.5 - p)

    z, middle = stats.norm.ppf(0.975), math.sqrt(total)
    place = z * math.sqrt(terms[0][0] / 7)
    out, back = (math.hypot(place, z * (math.sqrt(end(p)) - middle)) for p in (0.025, 0.975))
    assert found.sd == pytest.approx(middle, **EXACT)
    assert found.upper_ci.to_list() == pytest.approx([found.upper - back, found.upper + out])
    assert found.lower_ci.to_list() == pytest.approx([found.lower - out, found.lower + back])


def test_both_weightings_are_one_if_numbers_are_equal():
    rng = np.random.default_rng(1)
    y, x = rng.normal(0, 1, (2, 30))
    who = list(range(10)) * 3
    a, b = (repeated_limits(y, x, who, weighting=w) for w in ("pairs", "subjects"))
    for name in ("bias", "sd", "lower", "upper"):
        assert getattr(a, name) == pytest.approx(getattr(b, name), **EXACT)
    for name in ("bias_ci", "lower_ci", "upper_ci"):
        assert getattr(a, name).to_list() == pytest.approx(getattr(b, name).to_list(), **EXACT)


def test_a_pooled_deviation_is_that_of_loops_and_parts_seen_once_tell_nothing():
    values, parts = [1.0, 1.2, 5.0, 5.1, 5.3, 9.0, 1.1], ["a", "a", "b", "b", "b", "c", "a"]
    found = assess_repeatability(values, parts, tolerance=0.6, multiplier=5.15, level=0.9)
    a, b = [1.0, 1.2, 1.1], [5.0, 5.1, 5.3]
    squares = sum((v - sum(g) / len(g)) ** 2 for g in (a, b) for v in g)
    sigma = math.sqrt(squares / 4)
    assert (found.freedom, found.parts, found.measurements) == (4, 2, 6)
    assert found.sigma == pytest.approx(sigma, **EXACT)
    ends = [sigma * math.sqrt(4 / stats.chi2.ppf(p, 4)) for p in (0.95, 0.05)]
    assert found.sigma_ci.to_list() == pytest.approx(ends, **EXACT)
    assert found.p_t_percent == pytest.approx(100 * 5.15 * sigma / 0.6, **EXACT)
    ratio = [100 * 5.15 * end / 0.6 for end in ends]
    assert found.p_t_ci_percent.to_list() == pytest.approx(ratio, **EXACT)


def test_the_papers_own_ratio():
    """6 x 0.017 / 0.62 is 16.45 %; the article prints 16.42 %."""
    rng = np.random.default_rng(3)
    noise = rng.normal(0, 1, (14, 5))
    noise -= noise.mean(axis=1, keepdims=True)
    noise *= 0.017 / math.sqrt((noise**2).sum() / 56)
    values = (np.arange(2, 30, 2)[:, None] + noise).ravel()
    found = assess_repeatability(values, np.repeat(np.arange(14), 5).tolist(), tolerance=0.62)
    assert round(found.p_t_percent, 2) == 16.45
    assert [(v.below_percent, v.met, v.clear) for v in found.verdicts] == [
        (20, True, False),
        (10, False, True),
    ]


def plain_anova(rows):
    """Sums of squares of (part, operator, value) rows, by loops."""
    values = [v for *_, v in rows]
    grand = sum(values) / len(values)

    def means(key):
        groups = {}
        for row in rows:
            groups.setdefault(key(row), []).append(row[2])
        return {name: sum(g) / len(g) for name, g in groups.items()}

    part, operator, cell = means(lambda r: r[0]), means(lambda r: r[1]), means(lambda r: r[:2])
    return {
        "part": sum((part[p] - grand) ** 2 for p, _, _ in rows),
        "operator": sum((operator[o] - grand) ** 2 for _, o, _ in rows),
        "part x operator": sum(
            (cell[p, o] - part[p] - operator[o] + grand) ** 2 for p, o, _ in rows
        ),
        "repeatability": sum((v - cell[p, o]) ** 2 for p, o, v in rows),
        "total": sum((v - grand) ** 2 for v in values),
    }


@pytest.mark.parametrize("interaction", [0.0, 2.0])
def test_the_analysis_of_variance_is_that_of_loops_in_any_order_of_rows(interaction):
    rng = np.random.default_rng(4)
    effect = rng.normal(0, interaction, (6, 4))
    rows = [
        (f"p{p}", f"o{o}", 3 * p + 0.2 * o + effect[p, o] + rng.normal())
        for p in range(6)
        for o in range(4)
        for _ in range(3)
    ]
    rng.shuffle(rows)
    rows = [(str(p), str(o), float(v)) for p, o, v in rows]
    parts, operators, values = zip(*rows, strict=True)
    study, _, _ = crossed(values, parts, operators)
    found = analyse(study)
    assert found.pooled == (interaction == 0)
    table = {row.source: row for row in found.rows}
    for source, ss in plain_anova(rows).items():
        assert table[source].ss == pytest.approx(ss, rel=1e-9), source
    f = table["part x operator"]
    ratio = (f.ss / 15) / (table["repeatability"].ss / 48)
    assert (f.f, f.p) == pytest.approx((ratio, stats.f.sf(ratio, 15, 48)), rel=1e-9)
    against = table["repeatability, pooled"] if found.pooled else f
    assert table["part"].f == pytest.approx(
        (table["part"].ss / 5) / (against.ss / against.freedom), rel=1e-9
    )
    components = found.components
    if not found.pooled:
        ms = {name: row.ss / row.freedom for name, row in table.items()}
        expected = (ms["part"] - ms["part x operator"]) / 12
        assert components.part == pytest.approx(expected, rel=1e-9)
        expected = max((ms["operator"] - ms["part x operator"]) / 18, 0)
        assert components.operator == pytest.approx(expected, rel=1e-9, abs=1e-12)
        expected = (ms["part x operator"] - ms["repeatability"]) / 3
        assert components.interaction == pytest.approx(expected, rel=1e-9)
    for name in ("repeatability", "part", "gauge", "total"):
        value = components.repeatability if name == "repeatability" else getattr(components, name)
        interval = components.intervals[name]
        assert interval.low < value < interval.high


def test_an_interval_begins_at_0_exactly_where_the_f_test_does():
    F = float(stats.f.ppf(0.975, 9, 18))
    small, other = MeanSquare(0.3, 18), MeanSquare(1.1, 2)
    just = MeanSquare(0.3 * F, 9)
    assert difference_interval(just, small, 0.95).low == pytest.approx(0, abs=1e-8)
    assert difference_interval(MeanSquare(0.31 * F, 9), small, 0.95).low > 0
    assert ratio_interval(just, small, other, 0.7, 0.95).low == pytest.approx(0, abs=1e-12)
    F = float(stats.f.ppf(0.025, 9, 18))
    assert difference_interval(MeanSquare(0.3 * F, 9), small, 0.95).high == pytest.approx(
        0, abs=1e-8
    )


@pytest.mark.parametrize("pooled", [True, False])
def test_the_ratio_of_parts_to_gauge_is_burdicks_borrors_and_montgomerys(pooled):
    """Their table of MLS bounds, with the pooled error in the interaction's place if it is."""
    rng = np.random.default_rng(2)
    p, o, r = 8, 4, 3
    y = rng.normal(0, 3, (p, 1, 1)) + rng.normal(0, 0.5, (1, o, 1))
    y = y + rng.normal(0, 0.5, (p, o, 1)) + rng.normal(0, 1, (p, o, r))
    found = analyse(y, pool_above=-1 if pooled else 1)
    table = {row.source: row.square for row in found.rows}
    assert found.pooled == pooled
    if pooled:
        error = both = table["repeatability, pooled"]
        rest = (p * r - 1) * error.value
    else:
        both, error = table["part x operator"], table["repeatability"]
        rest = (p - 1) * both.value + p * (r - 1) * error.value
    part, operator = table["part"], table["operator"]
    ends = []
    for tail, quantile in ((0.975, 0.975), (0.025, 0.025)):
        G = (p - 1) / stats.chi2.ppf(quantile, p - 1)
        above = p * G * (part.value - stats.f.ppf(tail, p - 1, both.freedom) * both.value)
        F = stats.f.ppf(tail, p - 1, o - 1)
        ends.append(above / (o * (rest + G * F * operator.value)))
    assert found.components.part_to_gauge.to_list() == pytest.approx(ends, rel=1e-9)
    low, high = percent_of_total(found.components.part_to_gauge).to_list()
    assert [low, high] == pytest.approx([100 / math.sqrt(1 + end) for end in ends[::-1]])
    c = found.components
    assert low < 100 * math.sqrt(c.gauge / c.total) < high


def test_an_interval_of_one_mean_square_is_chi_squares():
    found = sum_interval([(2.0, MeanSquare(1.5, 7)), (0.0, MeanSquare(9.0, 3))], 0.95)
    ends = [7 * 3.0 / stats.chi2.ppf(p, 7) for p in (0.975, 0.025)]
    assert found.to_list() == pytest.approx(ends, **EXACT)
    assert mover([1.0], [Interval(0.5, 3.0)]).to_list() == pytest.approx([0.5, 3.0])


def test_categories_and_shares_follow_from_the_deviations():
    rng = np.random.default_rng(6)
    y = rng.normal(0, 2, (5, 1, 1)) + rng.normal(0, 1, (1, 3, 1)) + rng.normal(0, 0.4, (5, 3, 2))
    found = assess_gauge(y, tolerance=30, multiplier=5.15)
    told = found.to_dict()
    grr = math.sqrt(told["ev"] ** 2 + told["av"] ** 2 + told["interaction"] ** 2)
    assert told["grr"] == pytest.approx(grr, **EXACT)
    assert told["tv"] == pytest.approx(math.hypot(grr, told["pv"]), **EXACT)
    assert told["ndc"] == max(1, int(1.41 * told["pv"] / grr))
    assert told["grr_percent_tv"] == pytest.approx(100 * grr / told["tv"], **EXACT)
    assert told["percent_tolerance"]["grr"] == pytest.approx(100 * 5.15 * grr / 30, **EXACT)
    low, high = told["grr_percent_tv_ci"]
    assert low < told["grr_percent_tv"] < high


def test_single_limits_are_for_another_share_too(pairs):
    y, x = pairs
    found = single_limits(y - x, share=0.9)
    z = stats.norm.ppf(0.95)
    assert found.upper - found.bias == pytest.approx(z * (y - x).std(ddof=1), **EXACT)
