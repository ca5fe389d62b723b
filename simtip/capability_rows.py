"""The figures of a capability analysis in rows: a name, the value and its interval."""

from __future__ import annotations

from typing import Any

GAUGE_ROWS = {
    "ev": "EV repeatability",
    "av": "AV reproducibility",
    "interaction": "INT part x operator",
    "grr": "GRR",
    "pv": "PV parts",
    "tv": "TV total",
}

Row = tuple[str, float | None, list[float | None] | None]


def accuracy_rows(told: dict[str, Any]) -> list[Row]:
    """Give the figures of accuracy."""
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


def agreement_rows(told: dict[str, Any]) -> list[Row]:
    """Give bias, limits of agreement and correlations."""
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


def tests_in_words(told: dict[str, Any]) -> str:
    """Say what the tests of agreement found."""
    tests = {
        "proportional bias (Pitman-Morgan)": told["pitman_morgan_p"],
        "unequal scatter (Breusch-Pagan)": told["heteroscedasticity_p"],
        "not normal (Shapiro-Wilk)": told["normality_p"],
    }
    return ", ".join(f"{name} p = {_short(p)}" for name, p in tests.items())


def repeatability_rows(told: dict[str, Any]) -> list[Row]:
    """Give the scatter, and its part of the tolerance."""
    rows: list[Row] = [("sigma", told["sigma_mm"], told["sigma_ci_mm"])]
    if told["of_errors"] is not None:
        errors = told["of_errors"]
        rows.append(("sigma of errors", errors["sigma_mm"], errors["sigma_ci_mm"]))
    if told["p_t_percent"] is not None:
        k = f"{told['multiplier']:g}"
        rows.append((f"P/T, % ({k} sigma)", told["p_t_percent"], told["p_t_ci_percent"]))
    return rows


def verdict_in_words(verdict: dict[str, Any]) -> str:
    """Say whether a criterion is met."""
    side = "below" if verdict["met"] else "not below"
    sure = "clearly" if verdict["clear"] else "not clearly: the interval holds it"
    return f"P/T is {side} {verdict['below_percent']:g} %, {sure}"


def position_rows(result: dict[str, Any]) -> list[Row]:
    """Give errors of the tip's place."""
    told = result["position"]
    rows: list[Row] = [
        (f"mean error, {axis}", told[axis]["mean_mm"], told[axis]["mean_ci_mm"]) for axis in "xyz"
    ]
    return [*rows, ("RMS distance", told["rms_mm"], None), ("max distance", told["max_mm"], None)]


def remarks(result: dict[str, Any]) -> list[str]:
    """Say what was left out and why, and what a reader has to know."""
    said = [f"{name} is left out: {reason}" for name, reason in result["left_out"].items()]
    notes = list(result["notes"])
    for name in ("agreement", "grr"):
        notes += [] if result[name] is None else result[name]["notes"]
    return [*said, *(f"note: {note}" for note in notes)]


def _p(p: float | None) -> str:
    return "" if p is None else f" (p = {_short(p)})"


def _short(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
