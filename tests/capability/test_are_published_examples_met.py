"""Do worked examples of the literature come out to every printed digit?"""

from __future__ import annotations

import math

import numpy as np
import pytest
from capability.published import AIAG, MINI, WRIGHT, WRIGHT_AGAIN, rv_ic

from simtip.capability import assess_agreement, assess_gauge, assess_repeatability
from simtip.capability.d2_star import d2_star, range_moments
from simtip.capability.gauge_anova import analyse
from simtip.capability.gauge_ranges import from_ranges, study_ranges
from simtip.capability.limits import exact_factors, single_limits
from simtip.capability.repeated_limits import repeated_limits


def test_peak_flow_of_bland_and_altman_1986():
    found = assess_agreement(WRIGHT, MINI)
    assert round(found.limits.bias, 1) == -2.1
    assert round(found.limits.sd, 1) == 38.8
    assert [round(end, 1) for end in found.limits.bias_ci.to_list()] == [-22.0, 17.8]
    assert round(found.pearson_r, 2) == 0.94
    # They print the limits as d - 2 s and d + 2 s, from rounded figures.
    two = single_limits(np.subtract(WRIGHT, MINI), share=math.erf(2 / math.sqrt(2)))
    assert [two.lower, two.upper] == pytest.approx([-79.7, 75.5], abs=0.15)


def test_the_wright_meter_repeats_to_15_3_l_per_min():
    """Bland, An Introduction to Medical Statistics, section 20.2."""
    found = assess_repeatability([*WRIGHT, *WRIGHT_AGAIN], [*range(17), *range(17)])
    assert round(found.sigma, 1) == 15.3
    assert (found.freedom, found.parts, found.measurements) == (17, 17, 34)


def test_cardiac_output_of_bland_and_altman_2007_without_subjects():
    rv, ic, _ = rv_ic()
    found = single_limits(np.subtract(rv, ic))
    assert found.bias == pytest.approx(0.6021667, abs=5e-8)
    assert found.sd == pytest.approx(0.9610571, abs=5e-8)


def test_cardiac_output_of_bland_and_altman_2007_true_value_varies():
    rv, ic, who = rv_ic()
    found = repeated_limits(rv, ic, who)
    within, between = 0.170714026, (4.2090856 - 0.170714026) / 4.9818182
    assert found.bias == pytest.approx(0.6021667, abs=5e-8)
    assert found.within_sd**2 == pytest.approx(within, abs=5e-8)  # theirs is single precision
    assert found.between_sd**2 == pytest.approx(between, abs=2e-7)
    assert found.sd == pytest.approx(0.99062408, abs=1e-7)
    # Their limits take 1.96 for the quantile.
    assert found.bias - 1.96 * found.sd == pytest.approx(-1.3394565, abs=1e-6)
    assert found.lower == pytest.approx(-1.3394565, abs=5e-5)
    assert found.upper == pytest.approx(2.5437899, abs=5e-5)


def test_cardiac_output_of_bland_and_altman_2007_true_value_constant():
    rv, ic, who = rv_ic()
    found = repeated_limits(rv, ic, who, true_value="constant")
    assert found.within_sd**2 == pytest.approx(0.107227795 + 0.137874069, abs=1e-7)
    assert found.sd == pytest.approx(1.0518506, abs=5e-8)
    assert found.bias - 1.96 * found.sd == pytest.approx(-1.4594605, abs=1e-6)
    assert found.bias + 1.96 * found.sd == pytest.approx(2.6637939, abs=1e-6)


def test_intervals_of_zou_2013():
    """Zou's example: the first four subjects, linked pairs."""
    found = repeated_limits(*rv_ic(4), weighting="subjects")
    assert round(found.bias, 4) == 0.7255
    assert [round(found.lower, 2), round(found.upper, 2)] == [-2.14, 3.59]
    # Printed to 0.01, from rounded figures: the two intervals are not quite mirror images there.
    assert found.lower_ci.to_list() == pytest.approx([-9.83, -0.33], abs=0.01)
    assert found.upper_ci.to_list() == pytest.approx([1.77, 11.27], abs=0.01)


@pytest.mark.parametrize(("n", "factor"), [(10, 2.911), (20, 2.396), (30, 2.220)])
def test_exact_factors_are_tabulated_tolerance_factors(n, factor):
    """One-sided, 95 % of the population, 95 % confidence: Owen's table, ISO 16269-6."""
    assert round(exact_factors(n, 1.6448536269514722, 0.90)[1], 3) == factor


def test_aiag_gauge_study_by_analysis_of_variance():
    found = analyse(AIAG)
    table = {row.source: row for row in found.rows}
    for source, freedom, ss, ms in [
        ("part", 9, 88.3619, 9.81799),
        ("operator", 2, 3.1673, 1.58363),
        ("part x operator", 18, 0.3590, 0.01994),
        ("repeatability", 60, 2.7589, 0.04598),
    ]:
        row = table[source]
        assert (row.freedom, round(row.ss, 4), round(row.square.value, 5)) == (freedom, ss, ms)
    assert (table["total"].freedom, round(table["total"].ss, 4)) == (89, 94.6471)
    assert round(table["part x operator"].f, 3) == 0.434
    assert round(table["part x operator"].p, 3) == 0.974
    assert found.pooled
    pooled = table["repeatability, pooled"]
    assert (pooled.freedom, round(pooled.ss, 4), round(pooled.square.value, 5)) == (
        78,
        3.1179,
        0.03997,
    )


def test_aiag_gauge_study_in_its_report():
    found = assess_gauge(AIAG).to_dict()
    variances = {"ev": 0.03997, "av": 0.05146, "grr": 0.09143, "pv": 1.08645}
    assert {name: round(found[name] ** 2, 5) for name in variances} == variances
    printed = {"ev": 18.4, "av": 20.9, "interaction": 0, "grr": 27.9, "pv": 96.0}
    assert {name: round(found["percent_tv"][name], 1) for name in printed} == printed
    shares = {"ev": 3.4, "av": 4.4, "grr": 7.8, "pv": 92.2, "tv": 100.0}
    assert {name: round(found["percent_contribution"][name], 1) for name in shares} == shares
    assert found["ndc"] == 4
    assert round(found["grr"], 5) == 0.30237


def test_aiag_gauge_study_by_averages_and_ranges():
    found = study_ranges(AIAG)
    assert round(found.mean_range, 4) == 0.3417
    assert round(found.part_range, 3) == 3.511
    # AIAG goes on with rounded means, ranges and constants; the last digit shows it.
    printed = {"ev": 0.20188, "av": 0.22963, "grr": 0.30577, "pv": 1.10456, "tv": 1.14610}
    for name, value in printed.items():
        assert getattr(found, name) == pytest.approx(value, abs=1.2e-4), name
    assert round(100 * found.grr / found.tv, 1) == 26.7
    assert found.to_dict()["ndc"] == 5


def test_aiag_report_form_to_every_digit_from_its_own_rounded_entries():
    found = from_ranges(
        mean_range=0.3417,
        operator_difference=0.4446,
        part_range=3.511,
        shape=(10, 3, 3),
        constants=(0.5908, 0.5231, 0.3146),
    )
    printed = {"ev": 0.20188, "av": 0.22963, "grr": 0.30577, "pv": 1.10456, "tv": 1.14610}
    for name, value in printed.items():
        # The form rounds each line before it goes on; its EV and AV give GRR 0.30575.
        assert getattr(found, name) == pytest.approx(value, abs=2e-5), name


def test_range_factors_are_those_of_aiag_and_duncan():
    K2 = [0.7071, 0.5231]
    K3 = [*K2, 0.4467, 0.4030, 0.3742, 0.3534, 0.3375, 0.3249, 0.3146]
    assert [round(1 / d2_star(m, 1), 4) for m in range(2, 11)] == K3
    assert [round(1 / d2_star(m, 30), 4) for m in (2, 3)] == [0.8862, 0.5908]
    d2 = [1.12838, 1.69257, 2.05875, 2.32593, 2.53441, 2.70436, 2.84720, 2.97003, 3.07751]
    assert [round(range_moments(m)[0], 5) for m in range(2, 11)] == d2
    # Two normal values differ by sqrt(2) |normal|; three: 3 / sqrt(pi).
    mean, sd = range_moments(2)
    assert mean == pytest.approx(2 / math.sqrt(math.pi), abs=1e-12)
    assert sd == pytest.approx(math.sqrt(2 - 4 / math.pi), abs=1e-10)
    assert range_moments(3)[0] == pytest.approx(3 / math.sqrt(math.pi), abs=1e-12)
    assert round(d2_star(3, 5), 5) == round(math.sqrt(1.692569**2 + 0.888368**2 / 5), 5)
