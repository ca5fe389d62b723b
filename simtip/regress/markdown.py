"""A check as GitHub-flavoured Markdown, for the summary of a job."""

from __future__ import annotations

import html
import re
from typing import Any

from simtip.regress.change import SAME
from simtip.regress.compared import ORDER

SIGNS = {"worse": "❌", "could not tell": "❔", "moved": "↔️", "better": "✅", "same": "✅"}


def markdown_of(result: dict[str, Any]) -> str:
    """Write a check's result as Markdown: what changed, then a table of conditions, worst first.

    Parameters
    ----------
    result
        See `simtip.regress.result.result_of`.
    """
    sign = {"worse": "❌", "could not tell": "❔"}.get(result["verdict"], "✅")
    after = result["detector"]["after"]
    name = after["name"] or "the scenes' own detector"
    lines = [
        f"## {sign} simtip regress: {result['verdict']}",
        "",
        (
            f"Suite {_safe(result['suite'])}, {_safe(name)}, {len(result['conditions'])} "
            f"conditions, {result['comparison']} compared."
        ),
        "",
        *(f"- **{line['state']}**: {_safe(line['text'])}" for line in result["changes"]),
    ]
    if not result["changes"]:
        lines.append("Nothing changed.")
    if result["notes"]:
        lines += ["", *(f"- note: {_safe(note)}" for note in result["notes"])]
    lines += ["", "| | condition | found before | now | moved, px | spread | what |"]
    lines += ["|---|---|--:|--:|--:|--:|---|"]
    ordered = sorted(result["conditions"], key=lambda one: ORDER.index(one["state"]))
    lines += [_row(one) for one in ordered]
    told = result["statistics"]
    lines += [
        "",
        (
            f"False alarms: at most {100 * told['false_alarm_rate']:.2g} % of checks of an "
            f"unchanged detector, of {told['tests_of_conditions']} tests of conditions and "
            "those of all together."
        ),
    ]
    return "\n".join(lines) + "\n"


def _row(one: dict[str, Any]) -> str:
    before, after = one["before"], one["after"]
    cells = [
        SIGNS[one["state"]],
        _safe(one["name"]),
        _found(before),
        _found(after),
        _largest(one, "shift", "+.2f"),
        _largest(one, "spread", ".2g"),
        _safe(one["cause"] or ("" if one["state"] == SAME else one["state"])),
    ]
    return f"| {' | '.join(cells)} |"


def _found(side: dict[str, Any] | None) -> str:
    return "-" if side is None else f"{side['found'].count('1')}/{len(side['found'])}"


def _largest(one: dict[str, Any], kind: str, form: str) -> str:
    """Give the change of a kind that is the surest, with its view and axis."""
    mine = [test for test in one["tests"] if test["kind"] == kind and test["state"] != SAME]
    if not mine:
        return ""
    surest = min(mine, key=lambda test: test["p"])
    times = "x " if kind == "spread" else ""
    return f"{times}{surest['change']:{form}} {surest['view']} {surest['axis']}"


def _safe(text: str) -> str:
    """Show text as it is: no markup, no new cell, no HTML."""
    escaped = html.escape(" ".join(text.split()), quote=False)
    return re.sub(r"([\\`*_{}\[\]#|!~])", r"\\\1", escaped)
