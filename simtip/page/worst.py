"""The worst trials of a sweep, with their pictures and how to run them again."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from simtip.detect import names_code
from simtip.errors import SimtipError
from simtip.match import epipolar_line_left, epipolar_line_right
from simtip.measuring_rig import measuring_rig
from simtip.page.explorer import NORM
from simtip.page.options import Options
from simtip.page.parts import Code, Entry, Part, Section, View, Views, Words
from simtip.page.pictures import tip_view
from simtip.page.wording import length, signed
from simtip.scene_file import dump_scene
from simtip.sweep.cache import Cache, default_folder
from simtip.sweep.compact import compact
from simtip.sweep.frames import plain
from simtip.sweep.remaking import Again, Remaking
from simtip.sweep.shots import SIDES
from simtip.sweep.summary import OK
from simtip.truth import SceneTruth, scene_truth

if TYPE_CHECKING:
    import pandas as pd

    from simtip.sweep.table import Table

Row = dict[str, Any]

FAILURES = 3
"""Ways to fail of which one trial is shown each."""

OVERVIEW_PX = 520


def worst_section(
    table: Table, frame: pd.DataFrame, varying: Sequence[str], options: Options
) -> Section | None:
    """Show the trials with the largest errors, and one of each way to fail; None if none is.

    Images come from the cache, or are made anew.
    """
    rows = chosen(frame, options.pictures)
    if not rows:
        return None
    title = "Worst trials"
    try:
        folder = default_folder() if options.cache is None else options.cache
        remaking = Remaking(table, Cache(folder, None), options.backend)
    except SimtipError as error:
        return Section("worst", title, [Words([f"They cannot be shown: {error}"], note=True)])
    key = (
        "Cross: true tip. Ring: detected tip. Line: where the other view's detected tip may lie. "
        "Click a picture to zoom by wheel or keys; two fingers do, too."
    )
    parts: list[Part] = [Words([key], note=True)]
    for number, row in enumerate(rows):
        options.progress(number / len(rows))
        parts.append(_entry(row, varying, remaking))
    options.progress(1.0)
    return Section("worst", title, parts)


def chosen(frame: pd.DataFrame, pictures: int) -> list[Row]:
    """Give the rows with the largest errors, and the first row of the commonest failures."""
    if not pictures or not len(frame):
        return []
    measured = frame[frame[NORM].notna()] if NORM in frame else frame.iloc[:0]
    worst = measured.sort_values(NORM, ascending=False, kind="stable").head(pictures)
    failed = frame[(frame["status"] != OK).fillna(value=True)]
    common = failed["status"].value_counts(dropna=False).head(FAILURES).index
    examples = [failed[failed["status"] == status].head(1) for status in common]
    return [row for part in (worst, *examples) for row in _rows(part)]


def _rows(frame: pd.DataFrame) -> list[Row]:
    columns = {str(name): plain(frame[name]) for name in frame.columns}
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _entry(row: Row, varying: Sequence[str], remaking: Remaking) -> Entry:
    title = f"Trial {row['trial']}: " + (
        f"{length(row[NORM])} off" if row.get("status") == OK else "no tip"
    )
    remark = ", ".join(f"{name} {_said(row.get(name))}" for name in varying)
    parts: list[Part] = []
    if row.get("status") != OK:
        parts.append(Words([f"{row.get('reason') or 'No reason is told.'} ({row.get('status')})"]))
    try:
        trial = remaking.again(row)
    except SimtipError as error:
        return Entry(title, remark, [*parts, Words([f"It makes no scene: {error}"], note=True)])
    try:
        shot = remaking.images(row, trial)
    except SimtipError as error:
        parts.append(Words([f"Its images cannot be made: {error}"], note=True))
    else:
        if shot is not None:
            parts.append(Views(title, views_of(row, trial, shot.images)))
    return Entry(title, remark, [*parts, *again_parts(int(row["trial"]), trial)])


def _said(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.6g}"
    return "\N{EN DASH}" if value is None else compact(str(value))


def views_of(row: Mapping[str, Any], trial: Again, images: Sequence[Any]) -> list[View]:
    """Give both views of a row's trial: where the tip was detected is true tip + error."""
    truth = scene_truth(trial.scene)
    detected = [_detected(row, side, truth) for side in SIDES]
    lines = _lines(trial, detected)
    white_dn = 2**trial.scene.sensor.bit_depth - 1
    views = []
    for side, image, seen, line in zip(SIDES, images, detected, lines, strict=True):
        true = truth.left if side == "left" else truth.right
        caption = ""
        if seen is not None:
            along, across = (row[f"{side}_error_{way}_px"] for way in ("along", "across"))
            caption = f"{signed(along, 'px')} along, {signed(across, 'px')} across"
        views.append(
            tip_view(
                side,
                image,
                white_dn=white_dn,
                true=(float(true.tip_px[0]), float(true.tip_px[1])),
                detected=seen,
                axis=(float(true.axis_px[0]), float(true.axis_px[1])),
                line=line,
                caption=caption,
                overview_px=OVERVIEW_PX,
            )
        )
    return views


def _detected(row: Mapping[str, Any], side: str, truth: SceneTruth) -> tuple[float, float] | None:
    off = [row.get(f"{side}_error_{axis}_px") for axis in "uv"]
    if any(value is None or not math.isfinite(value) for value in off):
        return None
    true = (truth.left if side == "left" else truth.right).tip_px
    return float(true[0] + off[0]), float(true[1] + off[1])


def _lines(
    trial: Again, detected: Sequence[tuple[float, float] | None]
) -> list[tuple[float, float, float] | None]:
    """Give the epipolar line in each view, by the rig that measured; none of distorted views."""
    try:
        rig = measuring_rig(trial.scene)
    except SimtipError:  # its file is elsewhere
        return [None, None]
    left, right = detected
    lines: list[tuple[float, float, float] | None] = [None, None]
    if right is not None and not len(rig.left.distortion):
        lines[0] = _three(epipolar_line_left(right, rig))
    if left is not None and not len(rig.right.distortion):
        lines[1] = _three(epipolar_line_right(left, rig))
    return lines


def _three(line: Any) -> tuple[float, float, float] | None:
    a, b, c = map(float, line)
    return (a, b, c) if all(map(math.isfinite, (a, b, c))) else None


def again_parts(number: int, trial: Again) -> Iterator[Part]:
    """Give what runs a trial again: its scene, its light's scene, and the command."""
    if trial.noise_seed is None:
        return
    scene, light = f"trial_{number}.yaml", f"light_{number}.yaml"
    words = ["simtip", "run", scene, "--noise-seed", str(trial.noise_seed)]
    if trial.light is not None:
        words += ["--light", light]
    if names_code(trial.scene.detect.name):
        words += ["--detector", trial.scene.detect.name]
    words += ["-o", f"trial_{number}"]
    yield Code("To run it again, with the scene saved beside:", shlex.join(words))
    yield Code(f"Scene ({scene})", dump_scene(trial.scene), scene, folded=True)
    if trial.light is not None:
        what = f"Scene that its light was rendered for ({light})"
        yield Code(what, dump_scene(trial.light), light, folded=True)
    if not trial.same_light:
        said = (
            "Its light or images were made by other code than is installed, or on another back "
            "end: run again, the error may be slightly different."
        )
        yield Words([said], note=True)
