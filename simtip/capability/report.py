"""Everything that a table of measurements allows, and why the rest is left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.capability.accuracy import Accuracy, assess_accuracy
from simtip.capability.agreement import Agreement, assess_agreement
from simtip.capability.gauge import Gauge, assess_gauge
from simtip.capability.gauge_design import crossed
from simtip.capability.interval import spread
from simtip.capability.motion import Kind, Motion, motion
from simtip.capability.repeatability import MULTIPLIER, Repeatability, assess_repeatability
from simtip.capability.repeated_limits import TrueValue
from simtip.capability.table import Table

LEAST_ROWS = 3
NO_STEPS = "there is no r2_step: the steps of one column do not vary, or are fewer than 3"


@dataclass(frozen=True)
class Settings:
    """What a user may set; see `report_on`."""

    kind: Kind = "displacement"
    true_value: TrueValue | None = None
    tolerance: float | None = None
    multiplier: float = MULTIPLIER
    level: float = 0.95


@dataclass(frozen=True)
class Report:
    """Results by table; what is None is in `left_out`, with the reason.

    Attributes
    ----------
    table, settings
        What was analysed, and how.
    runs
        How many runs the rows make.
    repeatability_of_errors
        Of measured minus reference, so without the scatter of what was moved; None without
        reference.
    left_out
        Why a result is missing, by its name.
    notes
        What a reader has to know.
    """

    table: Table
    settings: Settings
    runs: int
    accuracy: Accuracy | None
    agreement: Agreement | None
    repeatability: Repeatability | None
    repeatability_of_errors: Repeatability | None
    grr: Gauge | None
    left_out: Mapping[str, str]
    notes: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Give plain values for JSON; lengths are in the table's own unit, whatever a key says."""
        errors = self.repeatability_of_errors
        repeatability = None if self.repeatability is None else self.repeatability.to_dict()
        if repeatability is not None:
            repeatability["of_errors"] = None if errors is None else errors.to_dict()
        return {
            "file": str(self.table.file),
            "rows": len(self.table.lines),
            "runs": self.runs,
            "columns": dict(self.table.headers),
            "readings": self.settings.kind,
            "level": self.settings.level,
            "accuracy": None if self.accuracy is None else self.accuracy.to_dict(),
            "agreement": None if self.agreement is None else self.agreement.to_dict(),
            "repeatability": repeatability,
            "grr": None if self.grr is None else self.grr.to_dict(),
            "left_out": dict(self.left_out),
            "notes": list(self.notes),
        }


def report_on(table: Table, settings: Settings | None = None) -> Report:
    """Analyse a table of measurements.

    Parameters
    ----------
    table
        As `read_table` gives it.
    settings
        ``kind``: what a reading is; ``true_value``: limits of agreement for repeated pairs of a
        part, its true value varying or constant; ``tolerance``: USL - LSL; ``multiplier``: k of
        P/T; ``level``: of all intervals.

    Raises
    ------
    InputError
        There are too few rows, a column does not vary, or a gauge study is not balanced.
    """
    chosen = settings or Settings()
    _refuse_too_little(table)
    left_out: dict[str, str] = {}
    runs = _runs(table)
    accuracy = agreement = None
    notes: list[str] = []
    if table.reference is None:
        left_out["accuracy"] = left_out["agreement"] = "there is no column reference"
    else:
        moved = motion(table.measured, table.reference, runs, chosen.kind)
        accuracy = _accuracy(table, moved, chosen)
        agreement = _agreement(table, moved, chosen)
        notes += _origin_note(table, chosen)
        if accuracy.r2_step is None:
            notes.append(NO_STEPS)
    repeatability, of_errors = _repeatability(table, chosen, left_out)
    return Report(
        table=table,
        settings=chosen,
        runs=len(set(runs)),
        accuracy=accuracy,
        agreement=agreement,
        repeatability=repeatability,
        repeatability_of_errors=of_errors,
        grr=_gauge(table, chosen, left_out),
        left_out=left_out,
        notes=tuple(notes),
    )


def _runs(table: Table) -> list[tuple[str, ...]]:
    """Tell runs by their column; without it, every trial of every operator is one."""
    return table.keys("run") if "run" in table.labels else table.keys("operator", "trial")


def _refuse_too_little(table: Table) -> None:
    count = len(table.lines)
    if count < LEAST_ROWS:
        raise table.error(
            f"{count} rows are too few: at least {LEAST_ROWS} are needed",
            "measured",
            count - 1,
            remedy="measure more often",
        )
    if spread(table.measured) == 0:
        raise table.error(
            f"all values, to line {table.lines[-1]}, are {table.measured[0]:g}: nothing varies",
            "measured",
            remedy="is it the right column?",
        )
    if table.reference is not None and spread(table.reference) == 0:
        raise table.error(
            f"all values, to line {table.lines[-1]}, are {table.reference[0]:g}: without "
            "variation there is no correlation",
            "reference",
            remedy="measure at different references, or leave the column out",
        )


def _accuracy(table: Table, moved: Motion, settings: Settings) -> Accuracy:
    if len(moved.rows) < LEAST_ROWS:
        raise table.error(
            f"{len(table.lines)} positions make {len(moved.rows)} displacements: at least "
            f"{LEAST_ROWS} are needed",
            "run" if "run" in table.labels else "measured",
            remedy="the first row of a run is its start: measure more",
        )
    enough = len(moved.steps[0]) >= LEAST_ROWS
    return assess_accuracy(
        moved.measured,
        moved.reference,
        steps=moved.steps if enough else None,
        cumulative=moved.cumulative,
        level=settings.level,
    )


def _agreement(table: Table, moved: Motion, settings: Settings) -> Agreement:
    parts = table.labels.get("part")
    subjects = None if parts is None else [parts[row] for row in moved.rows]
    if settings.true_value is not None:
        if subjects is None:
            raise table.error(
                "there is no column part",
                "--repeated",
                remedy="repeated pairs need the part that each is of",
            )
        if not 1 < len(set(subjects)) < len(subjects):
            raise table.error(
                "repeated pairs need two parts, one of them measured twice",
                "part",
                remedy="leave --repeated out",
            )
    return assess_agreement(
        moved.measured,
        moved.reference,
        subjects=subjects,
        true_value=settings.true_value,
        level=settings.level,
    )


def _origin_note(table: Table, settings: Settings) -> list[str]:
    if table.reference is None or settings.kind != "displacement":
        return []
    starts = int(np.sum((table.measured == 0) & (table.reference == 0)))
    if not starts:
        return []
    note = "of the rows are 0 in both columns: a start that is 0 by definition is no measurement"
    return [f"{starts} {note}, and makes errors look smaller"]


def _repeatability(
    table: Table, settings: Settings, left_out: dict[str, str]
) -> tuple[Repeatability | None, Repeatability | None]:
    """Pool over parts, or over parts by operators: another operator is not a repetition."""
    if "part" not in table.labels:
        left_out["repeatability"] = "there is no column part"
        return None, None
    cells = table.keys("part", "operator")
    if len(set(cells)) == len(cells):
        by = " by one operator" if "operator" in table.labels else ""
        left_out["repeatability"] = f"no part was measured twice{by}"
        return None, None

    def pooled(values: Any) -> Repeatability:
        return assess_repeatability(
            values,
            cells,
            tolerance=settings.tolerance,
            multiplier=settings.multiplier,
            level=settings.level,
        )

    if table.reference is None:
        return pooled(table.measured), None
    return pooled(table.measured), pooled(table.measured - table.reference)


def _gauge(table: Table, settings: Settings, left_out: dict[str, str]) -> Gauge | None:
    for name in ("part", "operator"):
        if name not in table.labels:
            left_out["grr"] = f"there is no column {name}"
            return None
        if len(set(table.labels[name])) == 1:
            left_out["grr"] = f"there is one {name} only"
            return None
    _refuse_unbalanced(table)
    study, _, _ = crossed(table.measured, table.labels["part"], table.labels["operator"])
    if study.shape[2] < 2:
        left_out["grr"] = "every operator measured every part once: it takes two trials"
        return None
    return assess_gauge(
        study,
        tolerance=settings.tolerance,
        multiplier=settings.multiplier,
        level=settings.level,
    )


def _refuse_unbalanced(table: Table) -> None:
    """Name the first part that an operator measured less often than others, and its line."""
    parts, operators = table.labels["part"], table.labels["operator"]
    counts = {
        (part, operator): 0
        for part in dict.fromkeys(parts)
        for operator in dict.fromkeys(operators)
    }
    for cell in zip(parts, operators, strict=True):
        counts[cell] += 1
    most = max(counts.values())
    for (part, operator), count in counts.items():
        if count < most:
            raise table.error(
                f"operator {operator[:40]!r} measured part {part[:40]!r} {_times(count)}, others "
                f"were measured {_times(most)}: gauge R&R needs equal numbers",
                "part",
                parts.index(part),
                remedy="fill in what is missing, drop the rest, or leave the operator out",
            )


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
