"""The page of a calibration."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from simtip.calibration_images.record import POINTS, RESULT, read_record
from simtip.calibration_rows import COEFFICIENTS, error_of, intrinsic
from simtip.page.folder import Results, TakenFrom
from simtip.page.origin import origin
from simtip.page.parts import Drawing, Fact, Grid, Page, Part, Section, Words
from simtip.page.wording import NONE, length

SIDES = ("left", "right")

TITLES = {
    "reprojection": "Reprojection errors of all corners, and their mean view by view.",
    "epipolar": "Distances of right corners from the epipolar lines of the left ones.",
    "coverage": "Where in the images corners were found, and how large their errors are there.",
    "error_map": "What this calibration alone does to places and steps in the working volume.",
}


def calibration_page(results: Results) -> Page:
    """Make the page of what `calibrate --plots` left."""
    told, record = results.json(RESULT), read_record(results.folder)
    from simtip.report.calibration import calibration_figures

    with TakenFrom(results.folder / POINTS):
        figures = calibration_figures(record)
    drawings = [Drawing(name, TITLES[name], figure) for name, figure in figures.items()]
    with TakenFrom(results.folder / RESULT):
        sections = [
            Section("rig", "The rig", [*_rig(told)]),
            Section("reprojection", "Reprojection", [drawings[0], _per_view(told)]),
            Section("epipolar", "Epipolar distances", [drawings[1]]),
            Section("coverage", "Coverage", [drawings[2]]),
        ]
        if "error" in told:
            parts: list[Part] = [*drawings[3:], *_against_truth(told)]
            sections.append(Section("truth", "Against the truth", parts))
        facts = {
            "folder": results.folder,
            "images": told["images"],
            "target": told["target"],
            "distortion model": told["model"],
            "truth": told.get("truth"),
            "convention": told["convention"],
            "time": ", ".join(f"{k} {v:.2f} s" for k, v in told["timings_s"].items()),
        }
        sections.append(origin(results.folder, facts, [RESULT, POINTS]))
        return Page(
            f"Calibration by {told['target']}",
            "calibrate",
            _verdict(told),
            list(_facts(told)),
            sections,
        )


def _verdict(told: dict[str, Any]) -> str:
    used, out = len(told["views_used"]), len(told["views_rejected"])
    said = f"{used} views, all used" if not out else f"{used} views used, {out} left out"
    return f"A stereo rig from {said}: corners are {told['rms_px']['stereo']:.3f} px off (RMS)."


def _facts(told: dict[str, Any]) -> Iterator[Fact]:
    rms = told["rms_px"]
    yield Fact(
        "RMS reprojection",
        f"{rms['stereo']:.3f} px",
        f"left {rms['left']:.3f}, right {rms['right']:.3f}",
    )
    yield Fact("Noise of a corner", f"{told['sigma_px']:.3f} px")
    distance = told["epipolar_rig_px"]
    yield Fact("Epipolar distance", f"{distance['mean']:.3f} px", f"at most {distance['max']:.3f}")
    deviation = told["std"]["baseline_mm"]
    yield Fact("Baseline", f"{told['baseline_mm']:.3f} mm", f"\N{PLUS-MINUS SIGN} {deviation:.4f}")
    if "error_at_needle_mm" in told:
        step = told["error_at_needle_mm"]["step"]
        worst = max(one["max"] for one in step.values())
        size = told["error_at_needle_mm"]["step_mm"]
        yield Fact("Error of a step", length(worst), f"at most, of {size:g} mm")


def _rig(told: dict[str, Any]) -> Iterator[Part]:
    judged = "error" in told
    heads = ["", "left", "\N{PLUS-MINUS SIGN} SD", "right", "\N{PLUS-MINUS SIGN} SD"]
    if judged:
        heads = [*heads[:3], "error", *heads[3:], "error"]
    rows = []
    for name in ("fx", "fy", "cx", "cy", *COEFFICIENTS[: len(told["D_left"])]):
        cells = [name]
        for side in SIDES:
            value, std = intrinsic(told, side, name)
            digits = 5 if name in COEFFICIENTS else 3
            cells += [f"{value:.{digits}f}", f"{std:.{digits}f}"]
            if judged:
                cells.append(f"{error_of(told, f'{side}.{name}'):+.{digits}f}")
        rows.append(cells)
    yield Grid("Cameras, px", heads, rows)
    std = told["std"]
    pose = [
        [
            f"R {k + 1}",
            *(f"{x:.5f} \N{PLUS-MINUS SIGN} {s:.5f}" for x, s in zip(row, of, strict=True)),
        ]
        for k, (row, of) in enumerate(zip(told["R"], std["R"], strict=True))
    ]
    pose.append(
        [
            "T, mm",
            *(
                f"{x:.4f} \N{PLUS-MINUS SIGN} {s:.4f}"
                for x, s in zip(told["T_mm"], std["T_mm"], strict=True)
            ),
        ]
    )
    yield Grid("Pose: P_left = R P_right + T", ["", "x", "y", "z"], pose)
    notes = [f"Left out: view {one['view']}: {one['reason']}" for one in told["views_rejected"]]
    notes += [f"Warning: {warning}" for warning in told["warnings"]]
    if told["corners_rejected"]:
        notes.append(
            f"{len(told['corners_rejected'])} corners of views that were used are left out."
        )
    if told["views_turned"]:
        notes.append(f"Numbered anew in the right image: views {', '.join(told['views_turned'])}.")
    if notes:
        yield Words(notes, note=True)


def _per_view(told: dict[str, Any]) -> Grid:
    rows = []
    for entry in told["per_view"]:
        cells = [entry["view"]]
        for side in SIDES:
            one = entry[side]
            cells += (
                [NONE] * 4
                if one is None
                else [
                    str(one["points"]),
                    *(f"{one[f'{k}_px']:.3f}" for k in ("mean", "rms", "max")),
                ]
            )
        rows.append(cells)
    heads = ["view", "left points", "mean", "RMS", "max", "right points", "mean", "RMS", "max"]
    return Grid("Reprojection error of each view, px", heads, rows)


def _against_truth(told: dict[str, Any]) -> Iterator[Part]:
    costs = told["error_at_needle_mm"]
    rows = [
        [name, "", f"{one['mean']:.5f}", f"{one['max']:.5f}"]
        for name, one in (("place", costs), ("place, a rigid fit off", costs["deformation"]))
    ]
    rows += [
        [f"step along {axis}", f"{one['bias']:+.5f}", f"{one['mean']:.5f}", f"{one['max']:.5f}"]
        for axis, one in costs["step"].items()
    ]
    title = f"Error at the needle by this calibration alone, mm; steps of {costs['step_mm']:g} mm"
    yield Grid(title, ["", "bias", "mean", "max"], rows)
    found = told["corner_error_px"]
    corners = [
        [
            name,
            str(one["points"]),
            *(f"{x:+.4f}" for x in one["bias"]),
            *(f"{x:.4f}" for x in one["sd"]),
            f"{one['max']:.4f}",
        ]
        for name, one in (("left", found["left"]), ("right", found["right"]), ("both", found))
    ]
    heads = ["", "points", "bias u", "bias v", "SD u", "SD v", "max"]
    yield Grid("Corners found less true ones, px", heads, corners)
