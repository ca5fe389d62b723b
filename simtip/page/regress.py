"""The page of a check against a baseline."""

from __future__ import annotations

from typing import Any

from simtip.page.folder import Results, TakenFrom
from simtip.page.origin import origin
from simtip.page.parts import Drawing, Fact, Grid, Page, Part, Section, Tone, Words
from simtip.page.wording import NONE, count, percent, signed
from simtip.regress.compared import ORDER
from simtip.regress.result import RESULT

SIDES = ("left", "right")
MOST_DRAWN = 60
"""Conditions, the worst first; a figure of more would be too long."""

MOST_PX = 1e6
"""No error in an image is larger, and no figure could show it."""

TONES: dict[str, Tone] = {"worse": "bad", "could not tell": "plain"}


def regress_page(results: Results) -> Page:
    """Make the page of a folder of `regress check`."""
    told = results.json(RESULT)
    with TakenFrom(results.folder / RESULT):
        conditions = sorted(told["conditions"], key=lambda one: ORDER.index(one["state"]))
        sections = [
            Section("changes", "What changed", _changes(told)),
            Section("conditions", "Conditions", _conditions(conditions)),
            Section("tests", "Tests", _tests(told, conditions)),
            _origin(results, told),
        ]
        title = f"{told['suite']}: {_name(told, 'after')}"
        return Page(title, "regress", _verdict(told), _facts(told), sections)


def _name(told: dict[str, Any], when: str) -> str:
    detector = told["detector"][when]
    name = str(detector["name"] or "the scenes' own detector")
    values = [f"{key}={value}" for key, value in detector["parameters"].items()]
    return f"{name} ({', '.join(values)})" if values else name


def _verdict(told: dict[str, Any]) -> str:
    said = str(told["verdict"])
    return (
        f"{said[:1].upper()}{said[1:]}: held to the baseline on {len(told['conditions'])} "
        f"conditions, {told['comparison']}."
    )


def _facts(told: dict[str, Any]) -> list[Fact]:
    tone = TONES.get(told["verdict"], "good")
    facts = [Fact("Verdict", str(told["verdict"]), f"exit code {told['exit_code']}", tone)]
    facts += [
        Fact(str(state).capitalize(), count(number), "conditions")
        for state, number in told["counts"].items()
        if number
    ]
    for test in told["pooled"]["tests"]:
        if test["kind"] == "detection":
            facts.append(
                Fact("Detection rate", percent(test["after"]), f"{percent(test['before'])} before")
            )
    time = told["time"]
    if time is not None and time.get("ratio") is not None:
        facts.append(
            Fact("Time", f"x {time['ratio']:.2f}", f"x {time['tolerance']:g} counts as slower")
        )
    return facts


def _changes(told: dict[str, Any]) -> list[Part]:
    # Checks by earlier versions have no notes.
    noted: list[Part] = [Words([str(note)], note=True) for note in told.get("notes", [])]
    if not told["changes"]:
        return [Words(["Nothing changed."]), *noted]
    rows = [
        [str(line["state"]), str(line["text"])]
        for line in sorted(told["changes"], key=lambda line: ORDER.index(line["state"]))
    ]
    return [Grid("Changes, the worst first", ["state", "what"], rows), *noted]


def _conditions(conditions: list[dict[str, Any]]) -> list[Part]:
    from simtip.report.changes import Bias, changes_figure

    drawn = [
        Bias(
            str(one["name"]),
            str(one["state"]),
            {side: _along(one["before"], side) for side in SIDES},
            {side: _along(one["after"], side) for side in SIDES},
        )
        for one in conditions[:MOST_DRAWN]
    ]
    parts: list[Part] = []
    if drawn:
        caption = (
            "Errors along the needle, positive where the tip is seen short: mean (dot) and "
            "standard deviation (bar), before and now."
        )
        parts.append(Drawing("changes", caption, changes_figure(drawn)))
    rows = []
    for one in conditions:
        cells = [str(one["name"]), str(one["state"]), _found(one["before"]), _found(one["after"])]
        for side in SIDES:
            cells += [_bias(one["before"], side), _bias(one["after"], side)]
        rows.append([*cells, str(one["cause"] or "")])
    heads = ["condition", "state", "found before", "now"]
    heads += ["left along before", "now", "right along before", "now", "cause"]
    return [*parts, Grid("Conditions, the worst first", heads, rows)]


def _along(side: dict[str, Any] | None, view: str) -> tuple[float, float] | None:
    told = None if side is None else side.get(view)
    if told is None or told["bias"][0] is None:
        return None
    bias, sd = float(told["bias"][0]), float(told["sd"][0] or 0.0)
    if max(abs(bias), abs(sd)) > MOST_PX:
        raise ValueError("no image is as large")
    return bias, sd


def _bias(side: dict[str, Any] | None, view: str) -> str:
    along = _along(side, view)
    return NONE if along is None else signed(along[0], "px")


def _found(side: dict[str, Any] | None) -> str:
    return NONE if side is None else f"{side['found'].count('1')}/{len(side['found'])}"


def _tests(told: dict[str, Any], conditions: list[dict[str, Any]]) -> list[Part]:
    heads = ["kind", "view", "before", "now", "change", "tolerance", "p", "state"]
    parts: list[Part] = [
        Grid("All conditions together", heads, [_test(test) for test in told["pooled"]["tests"]])
    ]
    rows = [
        [str(one["name"]), *_test(test)]
        for one in conditions
        for test in one["tests"]
        if test["state"] != "same"
    ]
    if rows:
        parts.append(Grid("Of single conditions, where not the same", ["condition", *heads], rows))
    stats = told["statistics"]
    said = (
        f"False alarms: at most {100 * stats['false_alarm_rate']:.2g} % of checks of an unchanged "
        f"detector, of {stats['tests_of_conditions']} tests of conditions and those of all "
        "together."
    )
    return [*parts, Words([said], note=True)]


def _test(test: dict[str, Any]) -> list[str]:
    return [
        str(test["kind"]),
        f"{test['view']} {test['axis']}".strip(),
        *(_number(test[key]) for key in ("before", "after", "change", "tolerance")),
        _number(test["p"]),
        str(test["state"]),
    ]


def _number(value: float | None) -> str:
    return NONE if value is None else f"{value:.4g}".replace("-", "\N{MINUS SIGN}")


def _origin(results: Results, told: dict[str, Any]) -> Section:
    before, after = told["made_with"]["before"], told["made_with"]["after"]
    facts: dict[str, object] = {
        "folder": results.folder,
        "baseline": told["baseline"],
        "detector before": _name(told, "before"),
        "detector now": _name(told, "after"),
        "seed of the noise": told["seed"],
        "levels of families of tests": ", ".join(
            f"{str(name).replace('_', ' ')} {level:g}"
            for name, level in told["statistics"]["levels"].items()
        ),
        "tolerances": ", ".join(f"{k} {v}" for k, v in told["statistics"]["tolerance"].items()),
        "accepted changes": len(told["accepted"]) or None,
    }
    names = dict.fromkeys([*before, *after])
    rows = [[str(name), str(before.get(name)), str(after.get(name))] for name in names]
    versions = Grid("Versions", ["what", "before", "now"], rows)
    return origin(results.folder, facts, [RESULT], [versions])
