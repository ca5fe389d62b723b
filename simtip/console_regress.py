"""What people see of baselines and checks: lines and a table on stdout."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from simtip.regress.baseline import Baseline
from simtip.regress.change import BETTER, MOVED, SAME, UNTOLD, WORSE
from simtip.regress.compared import ORDER

MOST_ROWS = 12
"""Of the table; all are in ``--json``."""

STYLES = {WORSE: "bold red", UNTOLD: "yellow", MOVED: "cyan", BETTER: "green", SAME: ""}


def show_check(result: dict[str, Any]) -> None:
    """Print what ``check --json`` holds: the verdict, what changed, and conditions that did."""
    console = Console()
    counts = {state: n for state, n in result["counts"].items() if n}
    said = ", ".join(f"{n} {state}" for state, n in counts.items())
    _line(
        console,
        f"{result['suite']}: {result['verdict']} ({said} of {len(result['conditions'])} "
        f"conditions; {result['comparison']} compared)",
    )
    for line in result["changes"]:
        _line(console, f"{line['state']}: {line['text']}")
    for note in result["notes"]:
        _line(console, f"note: {note}")
    changed = [one for one in result["conditions"] if one["tests"] and one["state"] != SAME]
    if changed:
        console.print(_table(changed))
    if result["comparison"] != "nothing":
        _line(console, _power(result))
    _line(console, _time(result["time"]))


def show_baseline(baseline: Baseline, what: str) -> None:
    """Print what a baseline holds, in a few lines."""
    console = Console()
    conditions = [(case, one) for case in baseline.cases for one in case.conditions]
    found = sum(one.found.count("1") for _, one in conditions)
    trials = sum(len(one.found) for _, one in conditions)
    _line(
        console,
        f"{what}: {baseline.suite.name}, {len(baseline.cases)} cases, {len(conditions)} "
        f"conditions; a tip in {found} of {trials} pairs of images",
    )
    silent = [case.case for case, one in conditions if "1" not in one.found]
    if silent:
        _line(console, f"without any tip: {', '.join(dict.fromkeys(silent))}")
    ratios = ", ".join(f"{one.case} {one.ratio:.3g}" for one in baseline.time)
    if ratios:
        _line(console, f"time over the reference operation's: {ratios}")


def _table(conditions: list[dict[str, Any]]) -> Table:
    """Give a line a condition, with the surest change of each kind."""
    table = Table(title="conditions that changed, the worst first")
    for heading in ("condition", "state", "found", "moved, px", "spread, px"):
        table.add_column(heading, overflow="fold")
    ordered = sorted(conditions, key=lambda one: ORDER.index(one["state"]))
    for one in ordered[:MOST_ROWS]:
        before, after = one["before"]["found"], one["after"]["found"]
        table.add_row(
            Text(one["name"]),
            Text(one["state"], style=STYLES[one["state"]]),
            f"{before.count('1')} -> {after.count('1')} of {len(after)}",
            _surest(one, "shift"),
            _surest(one, "spread"),
        )
    if len(ordered) > MOST_ROWS:
        table.add_row(f"and {len(ordered) - MOST_ROWS} more", "", "", "", "")
    return table


def _surest(one: dict[str, Any], kind: str) -> str:
    mine = [test for test in one["tests"] if test["kind"] == kind and test["state"] != SAME]
    if not mine:
        return ""
    test = min(mine, key=lambda test: (ORDER.index(test["state"]), test["p"]))
    return f"{test['view']} {test['axis']} {test['before']:.2f} -> {test['after']:.2f}"


def _power(result: dict[str, Any]) -> str:
    pooled = result["pooled"]["power"]
    own = next((one["power"] for one in result["conditions"] if one["power"]), None)
    parts = [f"all conditions together {_seen(pooled)}"]
    if own is not None:
        parts.append(f"one alone {_seen(own)}")
    rate = 100 * result["statistics"]["false_alarm_rate"]
    return (
        f"seen nine times of ten with fresh noise: {'; '.join(parts)}. "
        f"False alarms: at most {rate:.2g} % of checks"
    )


def _seen(power: dict[str, float | None]) -> str:
    shift, ratio, loss = power["shift_sigma"], power["spread_ratio"], power["loss"]
    told = [
        "no shift" if shift is None else f"a shift of {shift:.2g} standard deviations",
        "no spread" if ratio is None else f"{ratio:.2g} x the spread",
        "no loss" if loss is None else f"{100 * loss:.2g} % of tips lost",
    ]
    return ", ".join(told)


def _time(told: dict[str, Any] | None) -> str:
    if told is None:
        return "time: not compared"
    if told["ratio"] is None:
        return "time: could not be told"
    return f"time: x {told['ratio']:.2f} (x {told['tolerance']:g} counts)"


def _line(console: Console, text: str) -> None:
    console.print(text, markup=False, highlight=False, soft_wrap=True)
