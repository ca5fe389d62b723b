"""Why a condition cannot be compared: what differs from when the baseline was made."""

from __future__ import annotations

from simtip.regress.baseline import Baseline, CaseResult, ConditionResult, Versions
from simtip.regress.performed import Observed, Planned, levels_digest, scene_digest

MOST_VERSIONS = 3

NEW = "the baseline does not have it"
NO_CASE = "the suite no longer has this case"
NO_CONDITION = "the suite no longer has this condition"
_SCENE = "the scene was edited"
_LEVELS = "the levels of its factors were edited"
_NO_IMAGES = "there are no images"

_UPDATE = "`simtip regress update` accepts them"


def remedy_of(cause: str) -> str:
    """Say what may be done about conditions that cannot be compared for a cause."""
    if cause.startswith(_NO_IMAGES):
        return "see why they cannot be made"
    if cause == NO_CASE:
        return "`simtip regress update --all` accepts that"
    if cause in {NEW, NO_CONDITION, _SCENE, _LEVELS}:  # other noise does not make it the same scene
        return _UPDATE
    return f"`--seed N` compares statistically, with fresh noise; {_UPDATE}"


def cause_of(
    baseline: Baseline,
    recorded: CaseResult,
    before: ConditionResult,
    case: Planned,
    now: Observed,
    versions: Versions,
    *,
    fresh: bool,
) -> str | None:
    """Say why a condition cannot be compared; None if it can.

    Parameters
    ----------
    baseline, recorded, before
        What was recorded.
    case, now
        What was worked out.
    versions
        Of simtip and the libraries now.
    fresh
        Whether other noise than the baseline's was asked for.
    """
    if now.images is None:
        return f"{_NO_IMAGES}: {next(iter(now.failed), 'nothing was rendered')}"
    edited = _edited(recorded, case)
    if fresh or now.images == before.images:
        return edited if fresh else None
    return (
        edited
        or _seeds(recorded, case)
        or _repeats(before, now)
        or _versions(baseline.versions_of(recorded), versions)
    )


def _seeds(recorded: CaseResult, case: Planned) -> str:
    seeds = (
        ("the scene's seed", recorded.light_seed, case.plan.base.seed),
        ("the noise's seed", recorded.noise_seed, case.plan.seed),
    )
    return "; ".join(f"{what} is {new}, was {old}" for what, old, new in seeds if old != new)


def _repeats(before: ConditionResult, now: Observed) -> str | None:
    old, new = len(before.found), len(now.sample)
    return f"there are {new} repeats, and were {old}" if old != new else None


def _edited(recorded: CaseResult, case: Planned) -> str | None:
    if recorded.scene != scene_digest(case.plan):
        return _SCENE
    if recorded.levels != levels_digest(case.plan):
        return _LEVELS
    return None


def _versions(before: Versions, now: Versions) -> str:
    changed = [
        f"{name} {now.get(name)}, was {before.get(name)}"
        for name in {**before, **now}
        if name != "platform" and before.get(name) != now.get(name)
    ]
    if changed:
        return f"the images are others: {', '.join(changed[:MOST_VERSIONS])}"
    if before.get("platform") != now.get("platform"):
        return f"the images are others: another machine (it was {before.get('platform')})"
    return "the images are others, with the same versions: another machine or renderer"
