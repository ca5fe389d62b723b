"""200 checks of an unchanged detector with fresh noise: at most two may say that it is worse.

Errors are drawn from those that were measured on the standard suite (`measured_errors`).
"""

from __future__ import annotations

import numpy as np
import pytest
from measured_errors import detectors, pool_of

from simtip.regress.change import UNTOLD, WORSE
from simtip.regress.compared import compare
from simtip.regress.quantities import Pair
from simtip.regress.sample import Sample
from simtip.regress.tolerance import Tolerance

CHECKS = 200
REPEATS = 12


def drawn(pool: Sample, rng: np.random.Generator) -> Sample:
    chosen = rng.integers(0, len(pool), REPEATS)
    return Sample(pool.found[chosen], pool.error_px[chosen], pool.axis_px)


def verdict(before: dict[str, Sample], after: dict[str, Sample]) -> str:
    pairs = {name: Pair.of(before[name], after[name], paired=False) for name in before}
    return compare(pairs, Tolerance(), paired=False).state


@pytest.mark.slow
@pytest.mark.parametrize("detector", detectors())
def test_at_most_two_of_200_checks_alarm(detector):
    rng = np.random.default_rng(20)
    pool = pool_of(detector)
    states = []
    for _ in range(CHECKS):
        before, after = ({name: drawn(one, rng) for name, one in pool.items()} for _ in range(2))
        states.append(verdict(before, after))
    assert states.count(WORSE) <= 2
    assert states.count(UNTOLD) == 0


@pytest.mark.slow
@pytest.mark.parametrize("detector", detectors())
def test_of_a_dozen_checks_none_alarms(detector):
    rng = np.random.default_rng(21)
    pool = pool_of(detector)
    for _ in range(12):
        before, after = ({name: drawn(one, rng) for name, one in pool.items()} for _ in range(2))
        assert verdict(before, after) not in (WORSE, UNTOLD)


@pytest.mark.parametrize("detector", detectors())
def test_the_same_checks_see_a_half_pixel(detector):
    """Or they could not fail."""
    rng = np.random.default_rng(22)
    pool = pool_of(detector)
    before, after = ({name: drawn(one, rng) for name, one in pool.items()} for _ in range(2))
    moved = {
        name: Sample(one.found, one.error_px + np.array([0.5, 0.0]), one.axis_px)
        for name, one in after.items()
    }
    assert verdict(before, moved) == WORSE


@pytest.mark.parametrize("detector", detectors())
def test_the_same_checks_see_a_tenth_of_the_tips_lost(detector):
    rng = np.random.default_rng(23)
    pool = pool_of(detector)
    before, after = ({name: drawn(one, rng) for name, one in pool.items()} for _ in range(2))
    lost = {}
    for name, one in after.items():
        kept = rng.random(len(one)) > 0.1
        errors = np.where(kept[:, None, None], one.error_px, np.nan)
        lost[name] = Sample(one.found & kept, errors, one.axis_px)
    assert verdict(before, lost) == WORSE
