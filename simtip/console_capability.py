"""What people see of a measurement capability analysis: tables on stdout."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from simtip.detect.excerpt import printable

GAUGE_ROWS = {
    "ev": "EV repeatability",
    "av": "AV reproducibility",
    "interaction": "INT part x operator",
    "grr": "GRR",
    "pv": "PV parts",
    "tv": "TV total",
}

Row = tuple[str, float | None, list[float | None] | None]


def show_capability(result: dict[str, Any]) -> None:
    """Print what ``mca --json`` holds, as tables, with what was left out and why."""
    console = Console()
    _line(
        console,
        f"{result['file']}: {result['rows']} rows, {result['runs']} runs, "
        f"readings are {result['readings']}s; in the file's own unit",
    )
    _analyses(console, result)
    _remarks(console, result)


def show_experiment(result: dict[str, Any]) -> None:
    """Print what ``mca SCENE --json`` holds, likewise; lengths are in millimetres."""
    console = Console()
    seen = result["detection"]
    failed = "".join(f", {count} {name}" for name, count in seen["failed"].items())
    _line(
        console,
        f"{result['scene']}: {result['detector']}, {seen['measurements']} measurements, "
        f"{100 * seen['rate']:.4g} % with a tip{failed}; lengths in mm",
    )
    _analyses(console, result)
    title = f"position: measured - true, in the {result['position']['frame']}'s frame"
    _table(console, title, _percent(result), _position(result))
    frame = result["registration"]
    if frame is not None:
        error = frame["position_error_mm"]
        _line(
            console,
            f"registration of the stage's frame: FRE {_number(frame['fre_rms_mm'])} mm, turned by "
            f"{_number(frame['rotation_error_deg'])} degrees; tips in that frame are off by "
            f"{_number(error['rms'])} mm (RMS), {_number(error['max'])} mm at most",
        )
    _remarks(console, result)


def _percent(result: dict[str, Any]) -> str:
    return f"{100 * result['level']:g} % interval"


def _position(result: dict[str, Any]) -> list[Row]:
    told = result["position"]
    rows: list[Row] = [
        (f"mean error, {axis}", told[axis]["mean_mm"], told[axis]["mean_ci_mm"]) for axis in "xyz"
    ]
    return [*rows, ("RMS distance", told["rms_mm"], None), ("max distance", told["max_mm"], None)]


def _analyses(console: Console, result: dict[str, Any]) -> None:
    percent = _percent(result)
    if result["accuracy"] is not None:
        _table(console, "accuracy: measured - reference", percent, _accuracy(result["accuracy"]))
    if result["agreement"] is not None:
        agreement = result["agreement"]
        _table(console, "agreement", percent, _agreement(agreement))
        _line(console, agreement["method"])
        _line(console, _tests(agreement))
    if result["repeatability"] is not None:
        repeatability = result["repeatability"]
        _table(console, "repeatability", percent, _repeatability(repeatability))
        for verdict in repeatability["verdicts"]:
            _line(console, _verdict(verdict))
    if result["grr"] is not None:
        _gauge(console, result["grr"], percent)


def _accuracy(told: dict[str, Any]) -> list[Row]:
    rows: list[Row] = [
        ("mean error", told["mean_mm"], told["mean_ci_mm"]),
        ("mean |error|", told["mean_abs_mm"], told["mean_abs_ci_mm"]),
        ("RMS error", told["rms_mm"], told["rms_ci_mm"]),
        ("max |error|", told["max_abs_mm"], None),
    ]
    steps, line = told["steps"], told["linearity"]
    if steps is not None:
        rows += [
            ("mean |error| of steps", steps["mean_abs_mm"], steps["mean_abs_ci_mm"]),
            ("max |error| of steps", steps["max_abs_mm"], None),
        ]
    rows += [
        ("R2 of steps", told["r2_step"], None),
        ("R2 of displacements", told["r2_cumulative"], None),
        ("R2 of displacements, identity", told["r2_cumulative_identity"], None),
    ]
    if line is not None:
        rows += [
            (f"bias slope{_p(line['slope_p'])}", line["slope"], line["slope_ci"]),
            (
                f"bias at reference 0{_p(line['intercept_p'])}",
                line["intercept_mm"],
                line["intercept_ci_mm"],
            ),
        ]
    return rows


def _agreement(told: dict[str, Any]) -> list[Row]:
    share = f"{100 * told['share']:g} %"
    rows: list[Row] = [
        ("bias", told["bias_mm"], told["bias_ci_mm"]),
        ("SD of differences", told["sd_mm"], None),
        (f"lower limit, {share}", told["loa_lower_mm"], told["loa_lower_ci_mm"]),
        (f"upper limit, {share}", told["loa_upper_mm"], told["loa_upper_ci_mm"]),
        ("Pearson r", told["pearson_r"], told["pearson_r_ci"]),
        ("Lin's concordance", told["ccc"], told["ccc_ci"]),
    ]
    line = told["proportional_bias"]
    if line is not None:
        rows.append(("difference on mean, slope", line["slope"], line["slope_ci"]))
    return rows


def _tests(told: dict[str, Any]) -> str:
    tests = {
        "proportional bias (Pitman-Morgan)": told["pitman_morgan_p"],
        "unequal scatter (Breusch-Pagan)": told["heteroscedasticity_p"],
        "not normal (Shapiro-Wilk)": told["normality_p"],
    }
    return ", ".join(f"{name} p = {_short(p)}" for name, p in tests.items())


def _repeatability(told: dict[str, Any]) -> list[Row]:
    rows: list[Row] = [("sigma", told["sigma_mm"], told["sigma_ci_mm"])]
    if told["of_errors"] is not None:
        errors = told["of_errors"]
        rows.append(("sigma of errors", errors["sigma_mm"], errors["sigma_ci_mm"]))
    if told["p_t_percent"] is not None:
        k = f"{told['multiplier']:g}"
        rows.append((f"P/T, % ({k} sigma)", told["p_t_percent"], told["p_t_ci_percent"]))
    return rows


def _verdict(verdict: dict[str, Any]) -> str:
    side = "below" if verdict["met"] else "not below"
    sure = "clearly" if verdict["clear"] else "not clearly: the interval holds it"
    return f"P/T is {side} {verdict['below_percent']:g} %, {sure}"


def _gauge(console: Console, told: dict[str, Any], percent: str) -> None:
    table = Table(title="gauge R&R, analysis of variance")
    table.add_column("source")
    for heading in ("SD", percent, "% of TV", "% contribution", "% of tolerance"):
        table.add_column(heading, justify="right")
    for name, title in GAUGE_ROWS.items():
        tolerance = told["percent_tolerance"]
        table.add_row(
            title,
            _number(told[name]),
            _ends(told[f"{name}_ci"]),
            _number(told["percent_tv"][name], 4),
            _number(told["percent_contribution"][name], 4),
            "-" if tolerance is None else _number(tolerance[name], 4),
        )
    console.print(table)
    ranges = told["average_and_range"]
    _line(
        console,
        f"ndc {told['ndc'] or '-'}; GRR is {told['grr_percent_tv']:.4g} % of TV "
        f"({_ends(told['grr_percent_tv_ci'])}); by average and range: EV {_number(ranges['ev'])}, "
        f"AV {_number(ranges['av'])}, GRR {_number(ranges['grr'])}, PV {_number(ranges['pv'])}, "
        f"TV {_number(ranges['tv'])}, ndc {ranges['ndc'] or '-'}",
    )


def _remarks(console: Console, result: dict[str, Any]) -> None:
    for name, reason in result["left_out"].items():
        _line(console, f"{name} is left out: {reason}")
    notes = list(result["notes"])
    for name in ("agreement", "grr"):
        notes += [] if result[name] is None else result[name]["notes"]
    for note in notes:
        _line(console, f"note: {note}")


def _table(console: Console, title: str, percent: str, rows: list[Row]) -> None:
    table = Table(title=title)
    table.add_column("")
    table.add_column("value", justify="right")
    table.add_column(percent, justify="right")
    for name, value, interval in rows:
        table.add_row(Text(name), _number(value), _ends(interval))
    console.print(table)


def _line(console: Console, text: str) -> None:
    console.print(printable(text), markup=False, highlight=False, soft_wrap=True)


def _p(p: float | None) -> str:
    return "" if p is None else f" (p = {_short(p)})"


def _short(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _number(value: float | None, digits: int = 6) -> str:
    return "-" if value is None else f"{value:.{digits}g}"


def _ends(interval: list[float | None] | None) -> str:
    return "-" if interval is None else " .. ".join(_number(end) for end in interval)
