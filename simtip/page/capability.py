"""The page of an experiment: measurement capability."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from simtip.capability import Agreement, Repeatability
from simtip.capability.interval import Array, Interval
from simtip.capability.limits import Limits
from simtip.capability.regression import Regression
from simtip.capability.table import Table, read_table
from simtip.capability_rows import (
    GAUGE_ROWS,
    Row,
    accuracy_rows,
    agreement_rows,
    position_rows,
    remarks,
    repeatability_rows,
    tests_in_words,
    verdict_in_words,
)
from simtip.experiment.files import RESULT, ROWS, STEPS
from simtip.page.folder import Results, TakenFrom, damaged
from simtip.page.origin import origin
from simtip.page.parts import Code, Drawing, Fact, Grid, Page, Part, Section, Words
from simtip.page.wording import NONE, count, figure, interval, length, percent
from simtip.yaml_file.write import dump_yaml


def capability_page(results: Results) -> Page:
    """Make the page of a folder of `mca`."""
    told, head = results.json(RESULT), results.json("experiment.json")
    rows, steps = (_table(results, name) for name in (ROWS, STEPS))
    with TakenFrom(results.folder / RESULT):
        sections = _sections(told, rows, steps)
        sections.append(_origin(results, told, head))
        return Page(str(told["scene"]), "mca", _said(told), _facts(told), sections)


def _table(results: Results, name: str) -> tuple[Table, Array]:
    table = read_table(results.folder / name)
    if table.reference is None or "run" not in table.labels or "part" not in table.labels:
        raise damaged(results.folder / name)
    return table, table.reference


def _said(told: dict[str, Any]) -> str:
    accuracy, repeated = told["accuracy"], told["repeatability"]
    said = f"Displacements are wrong by {length(accuracy['mean_abs_mm'])} on average"
    if repeated is None:
        return f"{said}."
    said += f"; repeated, they scatter by {length(repeated['sigma_mm'])} (SD)"
    if repeated["p_t_percent"] is not None:
        tolerance = f"{repeated['tolerance_mm']:g} mm"
        said += f", which takes {repeated['p_t_percent']:.1f} % of a tolerance of {tolerance}"
    return f"{said}."


def _facts(told: dict[str, Any]) -> list[Fact]:
    accuracy, agreement = told["accuracy"], told["agreement"]
    seen, repeated, gauge = told["detection"], told["repeatability"], told["grr"]
    facts = [
        Fact("Measurements", count(seen["measurements"]), f"{percent(seen['rate'])} with a tip"),
        Fact(
            "Mean |error|",
            length(accuracy["mean_abs_mm"]),
            interval(accuracy["mean_abs_mm"], accuracy["mean_abs_ci_mm"]),
        ),
    ]
    if agreement is not None:
        ends = [agreement["loa_lower_mm"], agreement["loa_upper_mm"]]
        limits = interval(agreement["bias_mm"], ends)
        facts.append(Fact("Bias", length(agreement["bias_mm"]), f"limits {limits}"))
    if repeated is not None:
        around = interval(repeated["sigma_mm"], repeated["sigma_ci_mm"])
        facts.append(Fact("Repeatability (SD)", length(repeated["sigma_mm"]), around))
        if repeated["p_t_percent"] is not None:
            low, high = repeated["p_t_ci_percent"]
            said = f"[{figure(low)}, {figure(high)}] % of {repeated['tolerance_mm']:g} mm"
            facts.append(Fact("P/T", f"{repeated['p_t_percent']:.1f} %", said))
    if gauge is not None:
        facts.append(
            Fact("Gauge R&R", length(gauge["grr"]), f"{gauge['grr_percent_tv']:.2g} % of TV")
        )
    position = told["position"]
    at_most = f"at most {length(position['max_mm'])}"
    return [*facts, Fact("Position, RMS", length(position["rms_mm"]), at_most)]


def _sections(
    told: dict[str, Any], whole: tuple[Table, Array], single: tuple[Table, Array]
) -> list[Section]:
    from simtip.report.accuracy import accuracy_figure
    from simtip.report.bland_altman import bland_altman_figure

    level = f"{100 * told['level']:g} % interval"
    (rows, reference), (steps, of_steps) = whole, single
    measured = rows.measured
    runs = rows.labels["run"]
    sections = []
    if told["accuracy"] is not None:
        drawn = accuracy_figure(steps.measured, of_steps)
        sections.append(
            Section(
                "accuracy",
                "Accuracy",
                [
                    Drawing("accuracy", "Displacements by both methods, and their errors.", drawn),
                    _grid("Measured less reference, mm", level, accuracy_rows(told["accuracy"])),
                ],
            )
        )
    if told["agreement"] is not None:
        agreement = told["agreement"]
        found = _agreement(agreement, told["level"])
        drawn = bland_altman_figure(measured, reference, found, runs=runs)
        words = Words([f"{agreement['method']}. {tests_in_words(agreement)}."], note=True)
        caption = "Bland and Altman's plot: differences against means, bias, limits of agreement."
        grid = _grid("Agreement, mm", level, agreement_rows(agreement))
        sections.append(
            Section("agreement", "Agreement", [Drawing("agreement", caption, drawn), grid, words])
        )
    if told["repeatability"] is not None:
        parts = _repeatability(told["repeatability"], (rows, measured, reference), level)
        sections.append(Section("repeatability", "Repeatability", parts))
    if told["grr"] is not None:
        sections.append(Section("gauge", "Gauge R&R", _gauge(told["grr"], level)))
    sections.append(Section("position", "Position", _position(told, level)))
    notes = remarks(told)
    if notes:
        sections.append(Section("notes", "Notes", [Words(notes)]))
    return sections


def _repeatability(told: dict[str, Any], data: tuple[Table, Any, Any], level: str) -> list[Part]:
    from simtip.report.repeatability import repeatability_figure

    rows, measured, reference = data
    parts: list[Part] = []
    if told["of_errors"] is not None:
        found = _repeated(told["of_errors"])
        drawn = repeatability_figure(
            measured, reference, rows.labels["part"], rows.labels["run"], found
        )
        parts.append(
            Drawing("repeatability", "Errors of repeated runs against the displacement.", drawn)
        )
    parts.append(_grid("Repeatability, mm", level, repeatability_rows(told)))
    said = [verdict_in_words(verdict) for verdict in told["verdicts"]]
    return [*parts, Words([f"{'; '.join(said)}."])] if said else parts


def _gauge(told: dict[str, Any], level: str) -> list[Part]:
    tolerance = told["percent_tolerance"]
    rows = [
        [
            title,
            figure(told[name]),
            _ends(told[f"{name}_ci"]),
            figure(told["percent_tv"][name]),
            figure(told["percent_contribution"][name]),
            NONE if tolerance is None else figure(tolerance[name]),
        ]
        for name, title in GAUGE_ROWS.items()
    ]
    heads = ["source", "SD, mm", level, "% of TV", "% contribution", "% of tolerance"]
    anova = [
        [
            str(row["source"]),
            str(row["df"]),
            f"{row['ss']:.4g}",
            NONE if row["ms"] is None else f"{row['ms']:.4g}",
            NONE if row["f"] is None else f"{row['f']:.4g}",
            NONE if row["p"] is None else f"{row['p']:.2g}",
        ]
        for row in told["anova"]
    ]
    size = f"{told['parts']} places, {told['operators']} set-ups, {told['trials']} runs each"
    return [
        Grid(f"By analysis of variance: {size}", heads, rows, strong=(3,)),
        Grid("Analysis of variance", ["source", "df", "SS", "MS", "F", "p"], anova),
        Words([f"Number of distinct categories: {told['ndc'] or NONE}."], note=True),
    ]


def _position(told: dict[str, Any], level: str) -> list[Part]:
    parts: list[Part] = [_grid("Tip measured less true, mm", level, position_rows(told))]
    frame = told["registration"]
    if frame is not None:
        error = frame["position_error_mm"]
        said = (
            "Registration of the stage's frame: residuals "
            f"{length(frame['fre_rms_mm'])} (FRE), turned by "
            f"{frame['rotation_error_deg']:.3g} degrees; tips in that frame are off by "
            f"{length(error['rms'])} (RMS), {length(error['max'])} at most."
        )
        parts.append(Words([said]))
    return parts


def _grid(caption: str, level: str, rows: Sequence[Row]) -> Grid:
    cells = [[name, _six(value), _ends(ends)] for name, value, ends in rows]
    return Grid(caption, ["", "value", level], cells)


def _six(value: float | None) -> str:
    return NONE if value is None else f"{value:.6g}".replace("-", "\N{MINUS SIGN}", 1)


def _ends(ends: list[float | None] | None) -> str:
    return NONE if ends is None else f"[{', '.join(map(_six, ends))}]"


def _interval(ends: list[float] | None) -> Interval | None:
    return None if ends is None else Interval(ends[0], ends[1])


def _sure(ends: list[float | None]) -> Interval:
    low, high = (float("nan") if end is None else float(end) for end in ends)
    return Interval(low, high)


def _agreement(told: dict[str, Any], level: float) -> Agreement:
    """Give back what was found, as the figure takes it."""
    line = told["proportional_bias"]
    return Agreement(
        n=told["n"],
        share=told["share"],
        level=level,
        limits=Limits(
            bias=told["bias_mm"],
            bias_ci=_sure(told["bias_ci_mm"]),
            sd=told["sd_mm"],
            lower=told["loa_lower_mm"],
            lower_ci=_sure(told["loa_lower_ci_mm"]),
            upper=told["loa_upper_mm"],
            upper_ci=_sure(told["loa_upper_ci_mm"]),
            method=told["method"],
        ),
        proportional=None
        if line is None
        else Regression(
            line["slope"],
            _interval(line["slope_ci"]),
            line["slope_p"],
            line["intercept_mm"],
            _interval(line["intercept_ci_mm"]),
            line["intercept_p"],
        ),
        heteroscedasticity_p=told["heteroscedasticity_p"],
        normality_p=told["normality_p"],
        pearson_r=told["pearson_r"],
        pearson_r_ci=_interval(told["pearson_r_ci"]),
        concordance=None,
        notes=(),
    )


def _repeated(told: dict[str, Any]) -> Repeatability:
    return Repeatability(
        sigma=told["sigma_mm"],
        sigma_ci=_sure(told["sigma_ci_mm"]),
        freedom=told["degrees_of_freedom"],
        parts=told["parts"],
        measurements=told["measurements"],
        multiplier=told["multiplier"],
        tolerance=told["tolerance_mm"],
        p_t_percent=told["p_t_percent"],
        p_t_ci_percent=_interval(told["p_t_ci_percent"]),
        verdicts=(),
    )


def _origin(results: Results, told: dict[str, Any], head: dict[str, Any]) -> Section:
    facts = {
        "folder": results.folder,
        "made by": head.get("made_by"),
        "scene": told["scene"],
        "detector": told["detector"],
        "seed": told["seed"],
        "set-ups": ", ".join(map(str, told["setups"])),
        **{f"worked out: {name}": number for name, number in told["worked_out"].items()},
    }
    names = [RESULT, "experiment.json", ROWS, STEPS, "gauge.csv"]
    files = [name for name in names if (results.folder / name).is_file()]
    scene = dump_yaml(json.loads(json.dumps(head.get("scene"))))
    more = [Code("The scene, with every default", scene, "scene.yaml", folded=True)]
    return origin(results.folder, facts, files, more)
