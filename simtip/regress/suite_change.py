"""What a suite's file says otherwise than when the baseline was recorded."""

from __future__ import annotations

from simtip.regress.baseline import Baseline
from simtip.regress.recorded import suite_digest
from simtip.regress.suite import Suite
from simtip.regress.tolerance import Tolerance

TAKEN_OVER = "the baseline's counts until `simtip regress update` takes it over"


def notes_of(baseline: Baseline, suite: Suite) -> list[str]:
    """Say that a suite's file was edited, which its images alone do not show.

    Edited scenes, levels, seeds and repeats are causes of their conditions, and named there.

    Parameters
    ----------
    baseline
        What was recorded.
    suite
        As it is now.
    """
    if suite_digest(suite) == baseline.suite.sha256:
        return []
    notes = [
        f"the suite's tolerance.{name} is {new:g}, was {old:g}: {TAKEN_OVER}"
        for name in Tolerance.model_fields
        if (new := getattr(suite.spec.tolerance, name))
        != (old := getattr(baseline.tolerance, name))
    ]
    other = "the suite's file is another than when the baseline was recorded"
    return notes or [f"{other}, its tolerances the same; `simtip regress update` takes it over"]
