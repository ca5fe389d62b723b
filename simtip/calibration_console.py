"""A calibration as tables, the paper's Table 1 first."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from simtip.calibration_rows import COEFFICIENTS, error_of, intrinsic

SHOWN_CORNERS = 10
"""Outlying corners that are listed one by one."""


def show_calibration(result: dict[str, Any]) -> None:
    """Print what `simtip.calibration_images.Outcome.to_dict` gives."""
    console = Console()
    tables = [_cameras(result), _pose(result), _reprojection(result), _epipolar(result)]
    if "error" in result:
        tables += [_corners(result["corner_error_px"]), _needle(result["error_at_needle_mm"])]
    for table in tables:
        console.print(table)
    for line in _lines(result):
        console.print(Text(line), soft_wrap=True)


def _table(title: str, headings: Sequence[str]) -> Table:
    table = Table(title=title)
    for k, heading in enumerate(headings):
        table.add_column(heading, justify="right" if k else "left")
    return table


def _row(table: Table, *cells: str, style: str | None = None) -> None:
    # as Text: a name may hold what rich takes for markup
    table.add_row(*(Text(cell) for cell in cells), style=style)


def _cameras(result: dict[str, Any]) -> Table:
    judged = "error" in result
    headings = ["", "left", "± SD", "error", "right", "± SD", "error"]
    table = _table(
        f"cameras, px, model {result['model']}",
        [h for h in headings if judged or h != "error"],
    )
    for name in ("fx", "fy", "cx", "cy", *COEFFICIENTS[: len(result["D_left"])]):
        cells = [name]
        for side in ("left", "right"):
            value, std = intrinsic(result, side, name)
            digits = 5 if name in COEFFICIENTS else 3
            cells += [f"{value:.{digits}f}", f"{std:.{digits}f}"]
            if judged:
                cells.append(f"{error_of(result, f'{side}.{name}'):+.{digits}f}")
        _row(table, *cells)
    return table


def _pose(result: dict[str, Any]) -> Table:
    std = result["std"]
    table = _table("P_left = R P_right + T, ± SD", ("", "x", "y", "z"))
    for k, (row, deviations) in enumerate(zip(result["R"], std["R"], strict=True)):
        _row(table, f"R {k + 1}", *map(_within, row, deviations))
    _row(table, "T, mm", *map(_within, result["T_mm"], std["T_mm"]))
    if "error" in result:
        turns = [error_of(result, f"rotation_{axis}_deg") for axis in "xyz"]
        shifts = [error_of(result, f"T_{axis}_mm") for axis in "xyz"]
        _row(table, "error, deg", *map(_off_within, turns, std["rotation_deg"]))
        _row(table, "error, mm", *map(_off_within, shifts, std["T_mm"]))
    else:
        _row(table, "turn, deg", *(f"± {x:.5f}" for x in std["rotation_deg"]))
    return table


def _within(value: float, std: float) -> str:
    return f"{value:.5f} ± {std:.5f}"


def _off_within(error: float, std: float) -> str:
    return f"{error:+.5f} ± {std:.5f}"


def _reprojection(result: dict[str, Any]) -> Table:
    table = _table(
        "reprojection error, px",
        ("view", "left", "mean", "rms", "max", "right", "mean", "rms", "max"),
    )
    for entry in result["per_view"]:
        cells = [entry["view"]]
        for side in ("left", "right"):
            one = entry[side]
            cells += (
                ["-"] * 4
                if one is None
                else [
                    str(one["points"]),
                    *(f"{one[f'{k}_px']:.3f}" for k in ("mean", "rms", "max")),
                ]
            )
        _row(table, *cells)
    cells = ["all"]
    for side in ("left", "right"):
        ones = [entry[side] for entry in result["per_view"] if entry[side] is not None]
        points = sum(one["points"] for one in ones)
        worst = max(one["max_px"] for one in ones)
        means = (result["mean_px"][side], result["rms_px"][side], worst)
        cells += [str(points), *(f"{x:.3f}" for x in means)]
    table.add_section()
    _row(table, *cells, style="bold")
    return table


def _epipolar(result: dict[str, Any]) -> Table:
    table = _table(
        "right corners from their epipolar lines, px",
        ("F", "mean", "95 %", "max"),
    )
    for name, key in (
        ("eight-point, images as they are", "epipolar_raw_px"),
        ("eight-point, undistorted", "epipolar_px"),
        ("of the rig, undistorted", "epipolar_rig_px"),
    ):
        one = result[key]
        numbers = (one["mean"], one["quantiles"]["0.95"], one["max"])
        _row(table, name, *(f"{x:.4f}" for x in numbers))
    return table


def _corners(error: dict[str, Any]) -> Table:
    table = _table(
        "corners found less true ones, px",
        ("", "points", "bias u", "bias v", "SD u", "SD v", "max"),
    )
    for name, one in (("left", error["left"]), ("right", error["right"]), ("both", error)):
        numbers = (*(f"{x:+.4f}" for x in one["bias"]), *(f"{x:.4f}" for x in one["sd"]))
        _row(table, name, str(one["points"]), *numbers, f"{one['max']:.4f}")
    return table


def _needle(costs: dict[str, Any]) -> Table:
    table = _table(
        f"error at the needle by this calibration alone, mm, and in % of a {costs['step_mm']:g} mm "
        "step",
        ("", "bias", "mean", "max", "mean, %", "max, %"),
    )
    for name, one in (("place", costs), ("place, rigid fit off", costs["deformation"])):
        _row(table, name, "", f"{one['mean']:.5f}", f"{one['max']:.5f}", "", "")
    for axis, one in costs["step"].items():
        _row(
            table,
            f"step along {axis}",
            f"{one['bias']:+.5f}",
            f"{one['mean']:.5f}",
            f"{one['max']:.5f}",
            f"{one['mean_percent']:.4f}",
            f"{one['max_percent']:.4f}",
        )
    return table


def _lines(result: dict[str, Any]) -> Iterable[str]:
    used, rejected = len(result["views_used"]), result["views_rejected"]
    rms = result["rms_px"]
    length = f"baseline {result['baseline_mm']:.4f} ± {result['std']['baseline_mm']:.4f} mm"
    if "error" in result:
        length += f", error {error_of(result, 'baseline_mm'):+.4f} mm"
    yield length
    yield (
        f"{used} views used, {len(rejected)} left out; rms left {rms['left']:.4f}, right "
        f"{rms['right']:.4f}, both {rms['stereo']:.4f} px; noise of a corner "
        f"{result['sigma_px']:.4f} px"
    )
    for one in rejected:
        yield f"left out: view {one['view']}: {one['reason']}"
    corners = result["corners_rejected"]
    if corners:
        yield f"{len(corners)} corners left out of views that were used:"
    for one in corners[:SHOWN_CORNERS]:
        yield (
            f"  view {one['view']} {one['camera']}, corner {one['id']}: "
            f"{one['residual_px']:.2f} px off"
        )
    if len(corners) > SHOWN_CORNERS:
        yield f"  and {len(corners) - SHOWN_CORNERS} more, see --json"
    if result["views_turned"]:
        yield f"numbered anew in the right image: views {', '.join(result['views_turned'])}"
    for warning in result["warnings"]:
        yield f"warning: {warning}"
    yield ", ".join(f"{name} {value:.2f} s" for name, value in result["timings_s"].items())
