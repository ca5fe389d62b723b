"""Is twice the time twice the time, and a busy machine no reason to alarm?"""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

from simtip.regress.baseline import TimedCondition
from simtip.regress.change import BETTER, SAME, UNTOLD, WORSE
from simtip.regress.time_change import time_change
from simtip.regress.timing import Ratio, measured_ratio, running_time

SLICE_S = 0.002


class Machine:
    """A clock that operations move, on a machine whose turns others slow down at random."""

    def __init__(self, seed: int, busy: float = 0.0) -> None:
        self.now = 0.0
        self._rng, self._busy = np.random.default_rng(seed), busy

    def operation(self, seconds: float):
        def operate() -> None:
            left = seconds
            while left > 0:
                now = min(left, SLICE_S)
                self.now += now * (1 + self._busy * self._rng.exponential())
                left -= now

        return operate

    def clock(self) -> float:
        return self.now


def ratio(machine: Machine, detect_s: float, reference_s: float = 0.004) -> Ratio:
    operations = machine.operation(detect_s), machine.operation(reference_s)
    return measured_ratio(*operations, machine.clock)


@pytest.mark.parametrize("detect_s", [1e-5, 0.003, 0.05, 2.0])
def test_on_a_quiet_machine_the_ratio_is_exact(detect_s):
    found = ratio(Machine(1), detect_s)
    assert found.ratio == pytest.approx(detect_s / 0.004, rel=1e-6)
    assert found.scatter == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("detect_s", [0.003, 0.3])
def test_on_a_busy_machine_it_is_near_and_its_scatter_is_stated(detect_s):
    found = [ratio(Machine(seed, busy=1.0), detect_s) for seed in range(60)]
    logs = [math.log(one.ratio * 0.004 / detect_s) for one in found]
    assert abs(np.mean(logs)) < 0.1
    assert np.std(logs) < 1.6 * np.median([one.scatter for one in found]) + 0.02


def test_a_slow_detector_is_timed_in_few_turns():
    machine = Machine(1)
    ratio(machine, 20.0)
    assert machine.now < 20 * 7 * 2 + 150


def test_sleep_counts_and_work_counts():
    with running_time() as clock:
        start = clock()
        time.sleep(0.05)
        slept = clock() - start
        start, until = clock(), time.process_time() + 0.05
        while time.process_time() < until:
            pass
        worked = clock() - start
    assert 0.04 < slept < 0.5
    assert 0.04 < worked < 0.5


def recorded(scatter: float = 0.02) -> list[TimedCondition]:
    return [
        TimedCondition(case=name, condition="as it is", ratio=0.5, scatter=scatter)
        for name in ("a", "b", "c")
    ]


def state(*rounds: float, scatter: float = 0.02) -> tuple[str, float | None]:
    """Judge a detector whose conditions all take so many times as long, in each round."""
    calls = iter([value for value in rounds for _ in range(3)])
    change, _ = time_change(recorded(), lambda _: Ratio(0.5 * next(calls), scatter), 1.5)
    return change.state, change.ratio


def test_twice_as_slow_is_worse_and_half_the_time_better():
    assert state(2.0, 2.0) == (WORSE, pytest.approx(2.0))
    assert state(0.5)[0] == BETTER


def test_within_the_tolerance_is_the_same():
    assert state(1.2)[0] == SAME
    assert state(1.45, 1.45)[0] == SAME


def test_what_is_slow_once_only_is_not_slow():
    assert state(2.0, 1.0)[0] == SAME


def test_what_is_too_uncertain_is_not_told():
    assert state(1.8, 1.8, scatter=0.5)[0] == UNTOLD


def test_a_detector_that_does_not_end_is_not_told():
    change, _ = time_change(recorded(), lambda _: None, 1.5)
    assert change.state == UNTOLD
    assert "did not come to an end" in change.lines()[0].text


def test_the_words_say_how_much():
    change, _ = time_change(recorded(), lambda _: Ratio(1.0, 0.01), 1.5)
    assert change.lines()[0].text == "slower: 2.0 x the time"
