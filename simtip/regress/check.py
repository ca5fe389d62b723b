"""Check a detector against a baseline: work the suite out again, compare, say what changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from simtip.regress.baseline import Baseline, CaseResult, ConditionResult, TimedCondition, Versions
from simtip.regress.causes import NEW, NO_CASE, NO_CONDITION, cause_of, remedy_of
from simtip.regress.change import DETECTION, SAME, UNTOLD, WORSE
from simtip.regress.chosen import Chosen
from simtip.regress.compared import LEVEL, ORDER, Compared, compare, worst
from simtip.regress.conditions import full_name
from simtip.regress.line import Line
from simtip.regress.performed import Observed, Planned, Said, perform, planned
from simtip.regress.quantities import Pair
from simtip.regress.recorded import case_result, timed, versions_now
from simtip.regress.suite import Suite
from simtip.regress.suite_change import notes_of
from simtip.regress.time_change import TimeChange, time_change
from simtip.regress.timing import Asked, Ratio, time_in_worker
from simtip.regress.words import said_of
from simtip.sweep.campaign import Means
from simtip.sweep.pool import Pool

VERDICTS = {WORSE: "worse", UNTOLD: "could not tell"}
SAME_OR_BETTER = "same or better"
EXIT_CODES = {"worse": 1, "could not tell": 2, SAME_OR_BETTER: 0}

IMAGES = "images"


@dataclass(frozen=True, eq=False)
class Seen:
    """A condition before and after.

    Attributes
    ----------
    case, condition
        Names.
    before
        As recorded; None of a new one.
    after
        As worked out; None of one that the suite no longer has.
    now
        It, as a baseline would keep it.
    cause
        Why it cannot be compared; None if it is.
    """

    case: str
    condition: str
    before: ConditionResult | None
    after: Observed | None
    now: ConditionResult | None
    cause: str | None

    @property
    def name(self) -> str:
        """Case and condition in one."""
        return full_name(self.case, self.condition)


@dataclass(frozen=True, eq=False)
class Outcome:
    """A check.

    Attributes
    ----------
    suite, seed, detector, versions
        What was tried: the suite's name, the noise's seed if another than recorded, what
        measured.
    baseline
        What it is held to.
    cases, observed
        What was worked out.
    seen
        Every condition.
    compared
        The tests.
    time
        Of the detector.
    times_now
        By case and condition.
    lines
        What changed, in words.
    notes
        What else is to be known: how the suite's file differs from the recorded one.
    """

    suite: str
    seed: int | None
    detector: Chosen
    versions: Versions
    baseline: Baseline
    cases: Sequence[Planned]
    observed: Sequence[Sequence[Observed]]
    seen: Sequence[Seen]
    compared: Compared
    time: TimeChange | None
    times_now: Mapping[tuple[str, str], TimedCondition] = field(default_factory=dict)
    lines: Sequence[Line] = ()
    notes: Sequence[str] = ()

    @property
    def verdict(self) -> str:
        """The whole in a word."""
        return VERDICTS.get(worst(line.state for line in self.lines), SAME_OR_BETTER)

    @property
    def exit_code(self) -> int:
        """0 same or better, 1 worse, 2 could not tell."""
        return EXIT_CODES[self.verdict]

    def state_of(self, name: str) -> str:
        """Give what is said of a condition alone."""
        return worst(one.state for one in self.compared.conditions.get(name, ()))

    def changes_of(self, case: str) -> list[str]:
        """Say what changed in a case, in short."""
        told = []
        for one in self.seen:
            if one.case != case:
                continue
            if one.cause is not None:
                told.append(f"{one.condition}: {one.cause}")
            for change in self.compared.conditions.get(one.name, ()):
                if change.state != SAME:
                    told.append(  # noqa: PERF401 (two conditions read better so)
                        f"{one.condition}: {change.state}, {change.kind} {change.view} "
                        f"{change.axis} {_brief(change.before)} -> {_brief(change.after)}"
                    )
        return told


def check(
    baseline: Baseline,
    suite: Suite,
    detector: Chosen,
    folder: Path,
    means: Means,
    *,
    seed: int | None = None,
    only: Sequence[str] | None = None,
    said: Said = lambda _: None,
) -> Outcome:
    """Hold a detector to a baseline.

    Parameters
    ----------
    baseline
        What it is held to.
    suite
        The baseline's, as it is now.
    detector
        That is tried.
    folder
        Of the sweeps; gone on with.
    means
        What works on it.
    seed
        Of the noise: another one than the baseline's compares statistically. None is the same.
    only
        Names of cases; None is all.
    said
        Told what is begun.

    Raises
    ------
    InputError
        Something does not fit.
    KeyboardInterrupt
        The same call goes on.
    """
    chosen = [case for case in suite.cases if only is None or case.name in only]
    cases = planned(chosen, detector, means, baseline.seed if seed is None else seed)
    versions = versions_now(means.backend)
    pool = Pool(means.local_workers, lasting=True)
    try:
        observed = perform(cases, folder, means, pool, said)
        seen = _seen(baseline, cases, observed, versions, seed=seed, all_cases=only is None)
        said("timing the detector")
        times, now = _timed(baseline, cases, observed, pool)
    finally:
        pool.close()
    outcome = judged(
        *(suite.name, seed, detector, versions, baseline, cases, observed, seen, times, now)
    )
    return replace(outcome, notes=notes_of(baseline, suite))


def judged(
    suite: str,
    seed: int | None,
    detector: Chosen,
    versions: Versions,
    baseline: Baseline,
    cases: Sequence[Planned],
    observed: Sequence[Sequence[Observed]],
    seen: Sequence[Seen],
    time: TimeChange | None,
    times_now: Mapping[tuple[str, str], TimedCondition],
) -> Outcome:
    """Compare what was worked out; see `Outcome` for what is what."""
    pairs, paired = pairs_of(seen)
    compared = compare(pairs, baseline.tolerance, paired=paired)
    failed = {one.name: one.after.failed for one in seen if one.after is not None}
    lines = [
        *said_of(compared, pairs, failed, baseline.tolerance),
        *([] if time is None else time.lines()),
        *_untold(seen),
        *_too_few(compared),
    ]
    lines.sort(key=lambda line: ORDER.index(line.state))
    return Outcome(
        *(suite, seed, detector, versions, baseline, cases, observed, seen, compared, time),
        *(times_now, lines),
    )


def pairs_of(seen: Sequence[Seen]) -> tuple[dict[str, Pair], bool]:
    """Give what can be compared, by name, and whether all of it is of the same images."""
    usable = [
        (one.name, one.before, one.after)
        for one in seen
        if one.cause is None and one.before is not None and one.after is not None
    ]
    paired = bool(usable) and all(
        before.images == after.images and before.images is not None for _, before, after in usable
    )
    return {
        # The scene is the same, and so is what it shows.
        name: Pair.of(
            replace(before.sample, in_view=after.sample.in_view), after.sample, paired=paired
        )
        for name, before, after in usable
    }, paired


def _seen(
    baseline: Baseline,
    cases: Sequence[Planned],
    observed: Sequence[Sequence[Observed]],
    versions: Versions,
    *,
    seed: int | None,
    all_cases: bool,
) -> list[Seen]:
    """Put what was worked out beside what was recorded."""
    recorded = {one.case: one for one in baseline.cases}
    found = []
    for case, conditions in zip(cases, observed, strict=True):
        old = recorded.pop(case.name, None)
        found += _seen_case(baseline, old, case, conditions, versions, seed=seed)
    for name, old in recorded.items() if all_cases else ():
        found += [Seen(name, one.condition, one, None, None, NO_CASE) for one in old.conditions]
    return found


def _seen_case(
    baseline: Baseline,
    old: CaseResult | None,
    case: Planned,
    conditions: Sequence[Observed],
    versions: Versions,
    *,
    seed: int | None,
) -> list[Seen]:
    before = {} if old is None else {one.condition: one for one in old.conditions}
    now = case_result(case, conditions, baseline.tolerance, None)
    found = []
    for one, kept in zip(conditions, now.conditions, strict=True):
        was = before.pop(one.condition.name, None)
        if old is None or was is None:
            cause: str | None = NEW
        else:
            fresh = seed is not None and seed != old.noise_seed
            cause = cause_of(baseline, old, was, case, one, versions, fresh=fresh)
        found.append(Seen(case.name, one.condition.name, was, one, kept, cause))
    gone = [Seen(case.name, name, was, None, None, NO_CONDITION) for name, was in before.items()]
    return [*found, *gone]


def _timed(
    baseline: Baseline, cases: Sequence[Planned], observed: Sequence[Sequence[Observed]], pool: Pool
) -> tuple[TimeChange | None, dict[tuple[str, str], TimedCondition]]:
    """Time the detector where the baseline did; once more where it seems slower."""
    places = {
        (case.name, one.condition.name): (case, one)
        for case, conditions in zip(cases, observed, strict=True)
        for one in conditions
    }
    # A detector that crashes or finds nothing is not faster.
    asked = [
        one
        for one in baseline.time
        if (one.case, one.condition) in places
        and places[one.case, one.condition][1].sample.found.any()
    ]

    def measure(was: TimedCondition) -> Ratio | None:
        case, one = places[was.case, was.condition]
        return time_in_worker(pool, Asked(case.setup, one.condition.trials[0]))

    if not asked:
        return None, {}
    change, ratios = time_change(asked, measure, baseline.tolerance.time)
    now = {
        (was.case, was.condition): timed(*places[was.case, was.condition], ratio)
        for was, ratio in zip(asked, ratios, strict=True)
        if ratio is not None
    }
    return change, now


def _untold(seen: Sequence[Seen]) -> list[Line]:
    """Say which conditions could not be compared, those with one cause together."""
    causes: dict[str, list[str]] = {}
    for one in seen:
        if one.cause is not None:
            causes.setdefault(one.cause, []).append(one.name)
    return [
        Line(
            UNTOLD,
            IMAGES,
            tuple(names),
            f"{_listed(names, len(seen))} cannot be compared: {cause}; {remedy_of(cause)}",
        )
        for cause, names in causes.items()
    ]


def _listed(names: Sequence[str], total: int) -> str:
    if len(names) == total:
        return "all conditions" if total > 1 else names[0]
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(names[:3]) + more


def _too_few(compared: Compared) -> list[Line]:
    """Say that no change, however large, could have been seen."""
    pooled = next((one for one in compared.pooled if one.kind == DETECTION), None)
    if compared.paired or pooled is None or pooled.least_p <= LEVEL:
        return []
    return [
        Line(
            *(UNTOLD, DETECTION, ()),
            "too few repeats to see any change, however large; give the suite more",
        )
    ]


def _brief(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
