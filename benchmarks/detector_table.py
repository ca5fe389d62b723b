"""Figures of detectors as the Markdown of docs/detectors.md."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

GROUPS = {
    "nominal": "Nominal",
    "defocus": "Focus before (-) or behind (+) 170 mm",
    "background": "Gray of the background",
    "roughness": "Roughness of the needle",
    "lamps": "Lamps",
    "storage": "Lossy storage",
    "hard": "Hard images",
}
HEAD = (
    *("condition", "method", "pairs", "found", "right", "bias along, px", "across"),
    "RMSE along, px",
    *("across", "3-D RMSE, mm", "worst", "claimed / scatter", "efficiency", "ms"),
)


def table(stored: Mapping[str, Any]) -> str:
    """Make the Markdown: a table a group, and where it was measured."""
    where = stored["environment"]
    machine = f"{where['cpu_usable']} processor cores, {where['platform']}"
    parts = [f"Measured on {machine}, simtip {where['versions']['simtip']}.{_bounds(stored)}"]
    for group, title in GROUPS.items():
        rows = [one for one in stored["conditions"] if one["group"] == group]
        if rows:
            parts.append(f"### {title}\n\n{_table(rows)}")
    return "\n\n".join(parts)


def _bounds(stored: Mapping[str, Any]) -> str:
    """Say what the rows' efficiencies are over, if there are any."""
    rows = [one for condition in stored["conditions"] for one in condition["methods"].values()]
    telling = [one["settings"] for one in rows if one.get("efficiency_mm") is not None]
    if not telling:
        return ""
    poses = " or ".join(map(str, sorted({one["bound_poses"] for one in telling})))
    samples = " or ".join(map(str, sorted({one["bound_samples"] for one in telling})))
    return (
        f" Efficiency: over the pairs at the first {poses} poses of a condition (at all, if it has "
        f"no more), each pose with its own bound of {samples} samples: root mean square of the "
        "bounds over that of the errors."
    )


def _table(conditions: list[Mapping[str, Any]]) -> str:
    lines = [_row(HEAD), _row(["---", "---", *["---:"] * (len(HEAD) - 2)])]
    for condition in conditions:
        for k, (name, one) in enumerate(sorted(condition["methods"].items())):
            first = condition["name"] if k == 0 else ""
            lines.append(_row([first, f"`{name}`", *_cells(one)]))
    return "\n".join(lines)


def _row(cells: list[str] | tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"


def _cells(one: Mapping[str, Any]) -> list[str]:
    if "refused" in one:
        return ["", "not for this needle", *[""] * (len(HEAD) - 4)]
    found = _number(one["found"], "{:.0%}")
    if one["false"]:
        found += f", {one['false']} of {one['empty']} false"
    bias, rmse, claims = (
        one["bias_px"],
        one["rmse_px"],
        one["claimed_to_scatter"] or one.get("claimed_to_scatter_mm"),
    )
    return [
        str(one["pairs"]),
        found,
        _number(one["right"], "{:.0%}"),
        *(_part(bias, way, "{:+.3f}") for way in ("along", "across")),
        *(_part(rmse, way, "{:.3f}") for way in ("along", "across")),
        _number(one["rmse_mm"], "{:.4f}"),
        _number(one["largest_mm"], "{:.4f}"),
        _both(claims, "{:.2f}"),
        _number(one["efficiency_mm"], "{:.2g}"),
        f"{one['ms']:.1f}",
    ]


def _part(pair: Mapping[str, float] | None, way: str, form: str) -> str:
    return "" if pair is None else form.format(pair[way])


def _both(pair: Mapping[str, float] | None, form: str) -> str:
    return "" if pair is None else ", ".join(form.format(pair[way]) for way in ("along", "across"))


def _number(value: float | None, form: str) -> str:
    return "" if value is None else form.format(value)
