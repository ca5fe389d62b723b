"""Do intervals of an experiment hold the truth as often as they say, with starts that runs share?

Positions with independent normal errors; displacements from the start share that of the start.
"""

from __future__ import annotations

import numpy as np
import pytest

from simtip.capability import assess_agreement, assess_gauge, assess_repeatability
from simtip.capability.shared_runs import layout, limits_of, repeatability_of

RUNS, PLACES, TRIES, SD = 5, 15, 1000, 0.02


@pytest.fixture(scope="module")
def held():
    rng = np.random.default_rng(11)
    found = {"bias": 0, "sigma": 0, "lower": 0, "upper": 0}
    reference = np.tile(np.arange(2, 30, 2.0), (RUNS, 1))
    subjects = list(np.tile(np.arange(PLACES - 1), RUNS))
    for _ in range(TRIES):
        # Every place has an error of its own, too, as whole pixels make it.
        fixed = rng.normal(0, SD, PLACES)
        off = 0.29 * (np.arange(PLACES) > 0) + fixed + rng.normal(0, SD, (RUNS, PLACES))
        d = off[:, 1:] - off[:, :1]
        shared = layout(d)
        agreement = assess_agreement((reference + d).ravel(), reference.ravel())
        limits = limits_of(agreement.limits, shared, 0.95)
        # The start's own error is in all alike: the bias is that of this start.
        bias = 0.29 - fixed[0]
        found["bias"] += limits.bias_ci.low <= bias <= limits.bias_ci.high
        total = np.sqrt(3) * SD
        for name, end, ci in (
            ("lower", bias - 1.96 * total, limits.lower_ci),
            ("upper", bias + 1.96 * total, limits.upper_ci),
        ):
            found[name] += ci.low <= end <= ci.high
        repeat = repeatability_of(assess_repeatability(d.ravel(), subjects), shared, 0.95)
        found["sigma"] += repeat.sigma_ci.low <= np.sqrt(2) * SD <= repeat.sigma_ci.high
    return {name: count / TRIES for name, count in found.items()}


@pytest.mark.parametrize("name", ["bias", "sigma", "lower", "upper"])
def test_an_interval_holds_the_truth_in_95_of_100(held, name):
    assert held[name] >= 0.935


@pytest.mark.parametrize("name", ["bias", "sigma"])
def test_it_is_no_wider_than_need_be(held, name):
    assert held[name] <= 0.985


def test_equal_set_ups_show_no_reproducibility():
    """Of positions; displacements from one start showed some in seven of ten studies."""
    rng, found = np.random.default_rng(3), 0
    for _ in range(400):
        study = 2.0 * np.arange(15)[:, None, None] + rng.normal(0, SD, (15, 3, 2))
        row = next(r for r in assess_gauge(study).anova.rows if r.source == "operator")
        found += row.p is not None and row.p < 0.05
    assert found / 400 < 0.09
