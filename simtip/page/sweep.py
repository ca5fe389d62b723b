"""The page of a sweep."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from simtip.bound import pooled_efficiency
from simtip.errors import SimtipError
from simtip.page.explorer import MOST_ROWS, NORM, Told, told
from simtip.page.folder import Results
from simtip.page.options import Options
from simtip.page.origin import origin, versions
from simtip.page.parts import Code, Explorer, Fact, Grid, Page, Part, Section, Words
from simtip.page.still import still_figures
from simtip.page.wording import NONE, count, figure, length, lengths, percent
from simtip.page.worst import worst_section
from simtip.sweep.columns import FIXED
from simtip.sweep.compact import compact
from simtip.sweep.frames import kind_of, plain
from simtip.sweep.summary import OK, grouped
from simtip.sweep.table import Table
from simtip.yaml_file.write import dump_yaml

if TYPE_CHECKING:
    import pandas as pd

NEEDED = ("trial", "repeat", "detector", "status", "reason", NORM)
"""Columns without which there is no page."""

FEW = 8
"""So many different values of a factor are listed one by one."""


def sweep_page(results: Results, options: Options) -> Page:
    """Make the page of a sweep, also of one that is running."""
    table = Table.open(results.folder)
    table.require(NEEDED)
    frame = table.numbered()
    factors = [c.name for c in table.columns if c.name not in {c.name for c in FIXED}]
    varying = [
        name
        for name in (*factors, "detector", "repeat")
        if name in frame and len(frame[name].drop_duplicates()) > 1
    ]
    if options.bound is not None and len(frame):
        frame = _with_bounds(table, frame, factors, options)
    sections: list[Section] = [Section("overview", "Overview", _overview(frame, factors, varying))]
    data, settings = {}, {}
    if len(frame):
        shown = told(frame, varying, options.limit_mm)
        data, settings = {"trials": shown.data}, shown.settings
        sections += _explorers(varying, shown)
        worst = worst_section(table, frame, list(dict.fromkeys([*factors, *varying])), options)
        if worst is not None:
            sections.append(worst)
        sections.append(Section("trials", "Trials", [Explorer("trials")]))
    sections.append(_origin(results, table))
    return Page(
        _name(table),
        "sweep",
        _verdict(table, frame),
        _facts(table, frame),
        sections,
        data,
        settings,
        lambda: still_figures(frame, varying, options.limit_mm),
    )


def _name(table: Table) -> str:
    try:
        name = json.loads(table.provenance["scene"])["name"]
    except (KeyError, ValueError, TypeError):
        name = None
    return name if isinstance(name, str) and name.strip() else table.folder.resolve().name


def _errors(frame: pd.DataFrame) -> Any:
    values = frame[NORM].to_numpy(dtype=np.float64, na_value=math.nan)
    return values[np.isfinite(values)]


def _found(frame: pd.DataFrame) -> int:
    return int((frame["status"] == OK).fillna(value=False).sum())


def _verdict(table: Table, frame: pd.DataFrame) -> str:
    planned = table.provenance.get("trials")
    parts = []
    if isinstance(planned, int) and len(frame) < planned:
        parts.append(
            f"The sweep is not at its end: {count(len(frame))} of {count(planned)} trials are "
            "known."
        )
    if not len(frame):
        return " ".join(parts) or "There is no trial."
    found, errors = _found(frame), _errors(frame)
    parts.append(f"A tip was found in {count(found)} of {count(len(frame))} trials.")
    if len(errors) > 1:
        middle, most = lengths(float(np.median(errors)), float(np.percentile(errors, 95)))
        parts.append(f"Of those, half are within {middle} of the true tip, 95 % within {most}.")
    return " ".join(parts)


def _facts(table: Table, frame: pd.DataFrame) -> list[Fact]:
    planned = table.provenance.get("trials")
    of = f"of {count(planned)} planned" if isinstance(planned, int) else ""
    facts = [Fact("Trials", count(len(frame)), of)]
    if not len(frame):
        return facts
    found, errors = _found(frame), _errors(frame)
    tone = "good" if found == len(frame) else "bad" if found == 0 else "plain"
    missed = len(frame) - found
    facts.append(
        Fact(
            "Detection rate",
            percent(found / len(frame)),
            f"{count(missed)} without a tip" if missed else "",
            tone,  # type: ignore[arg-type]
        )
    )
    if len(errors):
        middle, high, most = lengths(
            float(np.median(errors)), float(np.percentile(errors, 95)), float(errors.max())
        )
        rms = length(float(np.sqrt(np.mean(errors**2))))
        facts += [
            Fact("Median error", middle, f"RMS {rms}"),
            Fact("95 % of errors below", high),
            Fact("Largest error", most),
        ]
    if "bound_mm" in frame:
        facts.append(_efficiency(frame))
    return facts


def _efficiency(frame: pd.DataFrame) -> Fact:
    own = frame[frame["bound_mm"].notna() & frame[NORM].notna()]
    value = pooled_efficiency(plain(own["bound_mm"]), plain(own[NORM]))
    if value is None:
        return Fact("Efficiency", NONE, "no trial has both a bound and an error")
    bound = length(float(own["bound_mm"].iloc[0]))
    return Fact("Efficiency", figure(value), f"bound {bound}, {count(len(own))} trials")


def _with_bounds(
    table: Table, frame: pd.DataFrame, factors: Sequence[str], options: Options
) -> pd.DataFrame:
    from simtip.page.efficiency import bounds_of
    from simtip.sweep.remaking import Remaking

    if options.bound is None:
        return frame
    remaking = Remaking(table, None, options.backend)
    return frame.assign(bound_mm=bounds_of(frame, factors, remaking, options.bound))


def _explorers(varying: Sequence[str], shown: Told) -> list[Section]:
    parts: list[Part] = [Explorer("filter")]
    if shown.left_out:
        said = (
            f"The page has room for {count(MOST_ROWS)} trials, drawn by lot: "
            f"{count(shown.left_out)} are left out of map, distributions and table. The numbers "
            "above, and the worst trials, are of all."
        )
        parts.insert(0, Words([said], note=True))
    if varying:
        parts.append(Explorer("map"))
    return [
        Section("envelope", "Operating envelope" if varying else "Which trials", parts),
        Section("distributions", "Distributions", [Explorer("distributions")]),
    ]


def _overview(frame: pd.DataFrame, factors: Sequence[str], varying: Sequence[str]) -> list[Part]:
    if not len(frame):
        return [Words(["No trial has come to its end yet."])]
    parts: list[Part] = []
    rows = [
        [name, count(frame[name].nunique(dropna=False)), _which(frame[name])]
        for name in dict.fromkeys([*factors, *varying])
    ]
    if rows:
        parts.append(Grid("What varies", ["field", "values", "which"], rows))
    parts.append(_by_detector(frame))
    ended = grouped(frame, ["status"], [])
    failed = ended[(ended["status"] != OK).fillna(value=True)]
    if len(failed):
        told_rows = [
            [str(status), count(int(n)), _first_reason(frame, status)]
            for status, n in zip(plain(failed["status"]), failed["n"], strict=True)
        ]
        parts.append(Grid("Why there is no tip", ["status", "trials", "e.g."], told_rows))
    return parts


def _by_detector(frame: pd.DataFrame) -> Grid:
    stats = ["detection_rate", *(f"{NORM}:{how}" for how in ("median", "rms", "p95", "max"))]
    refined = "refined_norm_mm" in frame and frame["refined_norm_mm"].notna().any()
    stats += ["refined_norm_mm:rms"] if refined else []
    found = grouped(frame, ["detector"] if "detector" in frame else [], stats)
    heads = ["detector", "trials", "detected", "median", "RMS", "95 %", "largest"]
    heads += ["RMS refined"] if refined else []
    heads += ["efficiency"] if "bound_mm" in frame else []
    rows = []
    for k in range(len(found)):
        row = found.iloc[k]
        name = row["detector"] if "detector" in frame else "all"
        cells = [str(name), count(int(row["n"])), percent(float(row["detection_rate"]))]
        cells += lengths(*(float(row[stat]) for stat in stats[1:]))
        if "bound_mm" in frame:
            cells.append(_efficiency(frame[frame["detector"] == name]).value)
        rows.append(cells)
    return Grid("Errors by detector", heads, rows)


def _first_reason(frame: pd.DataFrame, status: object) -> str:
    reasons = frame.loc[(frame["status"] == status).fillna(value=False), "reason"].dropna()
    return str(reasons.iloc[0]) if len(reasons) else NONE


def _which(column: pd.Series[Any]) -> str:
    """List a column's values if they are few, else the ends of their range."""
    values = plain(column.drop_duplicates().sort_values())
    said = [_said(value) for value in values]
    if len(said) <= FEW:
        return ", ".join(said)
    if kind_of(column) == "text":
        return ", ".join([*said[:FEW], ".."])
    known = [text for text, value in zip(said, values, strict=True) if value is not None]
    return f"{known[0]} .. {known[-1]}"


def _said(value: object) -> str:
    if value is None:
        return NONE
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else compact(str(value))


def _origin(results: Results, table: Table) -> Section:
    said = table.provenance
    facts = {
        "folder": results.folder,
        **versions(said),
        "back end": said.get("backend"),
        "seed of the noise": _seed(said),
        "plan": said.get("plan"),
    }
    parts: list[Part] = []
    for key, title, name in (
        ("sweep", "The sweep, with every default", "sweep.yaml"),
        ("scene", "Its scene, as far as it differs from the defaults", "scene.yaml"),
    ):
        try:
            text = dump_yaml(json.loads(said[key]))
        except (KeyError, TypeError, ValueError, SimtipError):
            continue
        parts.append(Code(title, text, name, folded=True))
    return origin(results.folder, facts, ["table.json"], parts)


def _seed(said: dict[str, Any]) -> object:
    try:
        own = json.loads(said["sweep"]).get("seed")
        return own if own is not None else json.loads(said["scene"]).get("seed", 0)
    except (KeyError, TypeError, ValueError, AttributeError):
        return None
