"""The fixture `simtip_suite`: all pairs of one case of a suite."""

from __future__ import annotations

import json
import reprlib
from collections.abc import Iterator, Mapping
from typing import Any

import pytest

from simtip.errors import InputError
from simtip.pytest_plugin.limits import Limits, is_number
from simtip.pytest_plugin.one_line import in_one_line
from simtip.pytest_plugin.pair import MeasuredPair, Pair
from simtip.pytest_plugin.selection import Selected
from simtip.pytest_plugin.suites import plan_of
from simtip.pytest_plugin.used import MOST_PICTURES, Used, used_by
from simtip.pytest_plugin.workshop import Workshop, workshop_of
from simtip.sweep.compact import compact
from simtip.sweep.plan import Plan, Trial
from simtip.sweep.stage_keys import digest_of

MOST_TOLD = 10
"""Pairs that a failed assertion tells of."""


class PairsOfCase:
    """The pairs of a case, made one after the other as they are asked for.

    Parameters
    ----------
    selected
        The case.
    workshop
        The session's.
    used
        Remembers the pairs.

    Raises
    ------
    InputError
        The case has a field that does not exist, or a value that does not fit.
    """

    def __init__(self, selected: Selected, workshop: Workshop, used: Used) -> None:
        self.suite, self.name = selected.suite, selected.case.name
        self._workshop, self._used = workshop, used
        self._plan = plan_of(selected.case, selected.repeats, workshop.seed)
        self._numbers = list(_distinct(self._plan))

    def __repr__(self) -> str:
        return f"<{len(self)} pairs of {self.name!r} of the suite {self.suite!r}>"

    def __len__(self) -> int:
        """Give the number of pairs."""
        return len(self._numbers)

    def __iter__(self) -> Iterator[Pair]:
        """Make the pairs, those of one condition together."""
        for number in self._numbers:
            with in_one_line():
                pair = self._pair(self._plan.trial(number))
            self._used.note(pair)
            yield pair

    def _pair(self, trial: Trial) -> Pair:
        setting, shot = self._workshop.make(self._plan, trial)
        parts = [self.name, _in_words(trial.values), f"repeat {trial.repeat + 1}"]
        name = ", ".join(part for part in parts if part)
        spec = setting.spec
        return Pair(name, spec, setting, shot, self._used, dict(trial.values), trial.repeat)

    def assert_tips_within(
        self,
        detector: object = None,
        *,
        share: float = 1.0,
        px: float | None = None,
        along_px: float | None = None,
        across_px: float | None = None,
        mm: float | None = None,
    ) -> None:
        """Measure the tip on every pair, and assert that it is where it should be.

        Parameters
        ----------
        detector
            See `Pair.measure`.
        share
            Of the pairs, that has to be within the limits, 0 to 1.
        px, along_px, across_px, mm
            See `MeasuredPair.assert_within`.
        """
        __tracebackhide__ = True
        with in_one_line():
            limits = Limits(px, along_px, across_px, mm)
            _require_share(share)
        failed = _Failed()
        for pair in self:
            done = pair.measure(detector)
            failed.take(done, limits.complaints(done))
        if (len(self) - failed.count) / len(self) < share:
            failed.note(self._used)
            said = f"{failed.count} of {len(self)} tips are not within {limits}"
            allowed = "" if share == 1 else f" ({share:.0%} have to be)"
            raise AssertionError("\n".join([f"{self.name}: {said}{allowed}", *failed.lines()]))


class _Failed:
    """The first few pairs that failed; images of all of them would fill the memory."""

    def __init__(self) -> None:
        self.count = 0
        self._drawn: list[MeasuredPair] = []
        self._told: list[str] = []

    def take(self, one: MeasuredPair, complaints: list[str]) -> None:
        """Take in what was found of one pair."""
        if not complaints:
            return
        self.count += 1
        if self.count <= MOST_PICTURES:
            self._drawn.append(one)
        if self.count <= MOST_TOLD:
            self._told += [f"  {one.pair.name}", *(f"    {line}" for line in complaints)]

    def note(self, used: Used) -> None:
        """Let pictures be drawn."""
        for one in self._drawn:
            used.note_failure(one.pair, one.measurement)
        used.left_out += self.count - len(self._drawn)

    def lines(self) -> list[str]:
        """Say what was wrong."""
        more = self.count - MOST_TOLD
        return [*self._told, *([f"  and {more} more"] if more > 0 else [])]


def _require_share(share: float) -> None:
    if not (is_number(share) and 0 < share <= 1):
        said = reprlib.repr(share)
        raise InputError(f"is {said}", field="share", remedy="give a number above 0, up to 1")


def case_for(request: pytest.FixtureRequest) -> PairsOfCase:
    """Give the pairs of the case that a test runs for."""
    with in_one_line():
        if not hasattr(request, "param"):
            raise InputError(
                "is there only for tests that pytest can run once a case",
                field="simtip_suite",
                remedy="name it among the arguments of a function, not of a unittest.TestCase",
            )
        return PairsOfCase(request.param, workshop_of(request.config), used_by(request))


def _distinct(plan: Plan) -> Iterator[int]:
    """Give the numbers of trials that differ in their scene or repeat: detectors are the test's."""
    seen = set()
    for number in range(len(plan)):
        trial = plan.trial(number)
        key = digest_of([dict(trial.values), trial.repeat])
        if key not in seen:
            seen.add(key)
            yield number


def _in_words(values: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{path}={compact(value if isinstance(value, str) else json.dumps(value))}"
        for path, value in values.items()
    )
