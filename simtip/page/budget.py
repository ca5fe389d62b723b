"""The page of an error budget."""

from __future__ import annotations

import json
import math
from typing import Any

from simtip.budget.figure import TITLES
from simtip.page.folder import Results, TakenFrom
from simtip.page.origin import origin
from simtip.page.parts import Code, Drawing, Fact, Grid, Page, Part, Section, Words
from simtip.page.wording import NONE, count, length
from simtip.yaml_file.write import dump_yaml


def budget_page(results: Results) -> Page:
    """Make the page of a folder of `budget`."""
    told, head = results.json("budget.json"), results.json("experiment.json")
    with TakenFrom(results.folder / "budget.json"):
        kinds = [(kind, told[kind]) for kind in TITLES if told[kind] is not None]
        sections = [Section(kind, _title(kind), _shares(kind, one, told)) for kind, one in kinds]
        sections.append(Section("causes", "The causes", _causes(told)))
        sections.append(_origin(results, told, head))
        return Page(str(told["scene"]), "budget", _verdict(kinds), _facts(kinds, told), sections)


def _title(kind: str) -> str:
    return TITLES[kind][:1].upper() + TITLES[kind][1:]


def _verdict(kinds: list[tuple[str, dict[str, Any]]]) -> str:
    if not kinds:
        return "No kind of error could be shared out: too few tips were seen in every state."
    kind, one = kinds[0]
    first = one["shares"][0]
    said = f"The RMS error of the {TITLES[kind]} is {length(one['rms_mm'])}."
    if first["percent"] is not None:
        said += (
            f" The largest part, {first['percent']:.0f} % of the mean square, is {first['cause']}."
        )
    return said


def _facts(kinds: list[tuple[str, dict[str, Any]]], told: dict[str, Any]) -> list[Fact]:
    short = {"position": "Position", "step": "Step", "from_start": "From the start"}
    facts = [
        Fact(
            f"{short[kind]}: RMS error", length(one["rms_mm"]), f"most: {one['shares'][0]['cause']}"
        )
        for kind, one in kinds
    ]
    recession = told["recession_mm"]
    low, high = length(recession["min"]), length(recession["max"])
    facts.append(Fact("Tip seen short by", length(recession["mean"]), f"{low} to {high}"))
    left_out = told["positions_left_out"]
    facts.append(
        Fact("Positions", count(told["positions"]), f"{left_out} left out" if left_out else "")
    )
    return facts


def _shares(kind: str, one: dict[str, Any], told: dict[str, Any]) -> list[Part]:
    from simtip.report.waterfall import Budget, waterfall_figure

    shares = one["shares"]
    panel = Budget(
        title=TITLES[kind],
        names=[str(row["cause"]) for row in shares],
        shares=[row["shapley_mm2"] for row in shares],
        intervals=[row["shapley_ci_mm2"] for row in shares],
        total=one["total_mm2"],
        total_interval=(one["total_ci_mm2"][0], one["total_ci_mm2"][1]),
    )
    rows = [
        [
            str(row["cause"]),
            NONE if row["percent"] is None else f"{row['percent']:.1f} %",
            _square(row["shapley_mm2"]),
            f"[{_square(row['shapley_ci_mm2'][0])}, {_square(row['shapley_ci_mm2'][1])}]",
            _root(row["alone_mm2"]),
            length(row["rms_without_mm"]),
        ]
        for row in shares
    ]
    level = f"{100 * told['level']:g} % interval"
    heads = ["cause", "share", "mm\N{SUPERSCRIPT TWO}", level, "alone", "RMS without"]
    caption = (
        "What each cause adds to the mean square error, from the remainder to the total; whiskers: "
        f"{100 * told['level']:g} % intervals."
    )
    return [
        Drawing(f"budget_{kind}", caption, waterfall_figure([panel])),
        Grid("Shares", heads, rows),
    ]


def _square(value: float) -> str:
    return f"{value:.3g}".replace("-", "\N{MINUS SIGN}")


def _root(square: float) -> str:
    return length(math.copysign(math.sqrt(abs(square)), square))


def _causes(told: dict[str, Any]) -> list[Part]:
    rows = [[str(cause), str(without)] for cause, without in told["causes"].items()]
    parts: list[Part] = [Grid("Present", ["cause", "the state without it"], rows)]
    absent = [[str(cause), str(why)] for cause, why in told["absent"].items()]
    if absent:
        parts.append(Grid("Absent", ["cause", "why"], absent))
    if told["refused_by_matching"]:
        share = f"{100 * told['refused_by_matching']:.3g} %"
        parts.append(
            Words(
                [f"Matching would refuse {share} of these measurements; they count here."],
                note=True,
            )
        )
    return parts


def _origin(results: Results, told: dict[str, Any], head: dict[str, Any]) -> Section:
    facts = {
        "folder": results.folder,
        "made by": head.get("made_by"),
        "scene": told["scene"],
        "detector": told["detector"],
        "seed": told["seed"],
        "replicates": told["replicates"],
        **{f"worked out: {name}": number for name, number in told["worked_out"].items()},
    }
    scene = dump_yaml(json.loads(json.dumps(head.get("scene"))))
    more = [Code("The scene, with every default", scene, "scene.yaml", folded=True)]
    return origin(results.folder, facts, ["budget.json", "experiment.json"], more)
