"""The page of one scene: what `run`, `render` and `remix` leave."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simtip.errors import InputError
from simtip.geometry import Array
from simtip.image_file import read_image
from simtip.match import epipolar_line_left, epipolar_line_right
from simtip.page.folder import Results, TakenFrom, own_file
from simtip.page.origin import origin, sha256_of, versions
from simtip.page.parts import Code, Fact, Grid, Page, Part, Section, View, Views, Words
from simtip.page.pictures import Point, tip_view
from simtip.page.wording import NONE, figure, length, signed
from simtip.rig_file import read_rig

SIDES = ("left", "right")

KEY = (
    "Cross: true tip. Ring: detected tip. Line: where the other view's detected tip may lie. Click "
    "a picture to zoom by wheel or keys (+, -, arrows, 0); two fingers do, too."
)


def run_page(results: Results) -> Page:
    """Make the page of a folder of `run`, `render` or `remix`."""
    truth, manifest = results.json("truth.json"), results.json("manifest.json")
    result = results.json("result.json") if results.kind == "run" else None
    folder, scene = results.folder, results.text("scene.yaml")
    name, verdict = _name_in(scene), "Images and truth of a scene; nothing was measured."
    marks, facts, errors = _Marks.none(), list[Fact](), list[Section]()
    if result is not None:
        with TakenFrom(folder / "result.json"):
            name, verdict, marks = str(result["scene"]), _said(result), _marks(folder, result)
            facts, errors = _facts(result), [Section("error", "Error", _error(result))]
    with TakenFrom(folder / "truth.json"):
        views = [_view(folder, side, truth, marks) for side in SIDES]
        true = Section("truth", "Truth", _truth(truth))
    with TakenFrom(folder / "manifest.json"):
        facts += _exposure(manifest)
        made = _origin(results, manifest, scene)
    shown = Section("images", "Images", [Words([KEY], note=True), Views(name, views)])
    title = name or folder.resolve().name
    return Page(title, results.kind, verdict, facts, [shown, *errors, true, made])


@dataclass(frozen=True)
class _Marks:
    """What was measured in each view, by side: detected tips, epipolar lines, captions."""

    detected: Mapping[str, Point | None]
    lines: Mapping[str, tuple[float, float, float] | None]
    captions: Mapping[str, str]

    @classmethod
    def none(cls) -> _Marks:
        return cls(dict.fromkeys(SIDES), dict.fromkeys(SIDES), dict.fromkeys(SIDES, ""))


def _name_in(scene: str) -> str:
    from simtip.yaml_file import parse_yaml

    value = parse_yaml(scene.encode(), "scene.yaml").value
    name = value.get("name") if isinstance(value, dict) else None
    return name if isinstance(name, str) else ""


def _said(result: dict[str, Any]) -> str:
    if result["status"] != "ok":
        return f"No tip was measured: {result['reason']} ({result['status']})."
    return (
        f"{result['detector']} measures the tip {length(result['error_mm']['norm'])} from where it "
        "is."
    )


def _exposure(manifest: dict[str, Any]) -> list[Fact]:
    exposure = manifest.get("exposure_s")
    return [Fact("Exposure", f"{1e3 * exposure:.4g} ms")] if exposure else []


def _facts(result: dict[str, Any]) -> list[Fact]:
    if result["status"] != "ok":
        return [Fact("Tip", "not measured", str(result["status"]), "bad")]
    facts = [Fact("Error", length(result["error_mm"]["norm"]))]
    for side in SIDES:
        error = result["error_px"][side]
        if error is not None:
            across = signed(error["across"], "px")
            facts.append(
                Fact(
                    f"{side.title()} view",
                    f"{signed(error['along'], 'px')} along",
                    f"{across} across",
                )
            )
    distance = result.get("epipolar_distance_px")
    if distance is not None:
        facts.append(Fact("Epipolar distance", f"{distance:.3f} px"))
    told = result.get("efficiency")
    if told:
        best = max((v for k, v in told.items() if k != "bound_mm" and v is not None), default=None)
        facts.append(Fact("Efficiency", figure(best), f"bound {length(told['bound_mm'])}"))
    return facts


def _marks(folder: Path, result: dict[str, Any]) -> _Marks:
    detected = {side: _point(result["tip_detected_px"][side]) for side in SIDES}
    captions = {side: _caption(result["error_px"][side], detected[side]) for side in SIDES}
    return _Marks(detected, _lines(folder, detected), captions)


def _view(folder: Path, side: str, truth: dict[str, Any], marks: _Marks) -> View:
    image = read_image(folder / f"{side}.png")
    return tip_view(
        side,
        image,
        white_dn=_white(folder, image),
        true=_point(truth[side]["tip_px"]),
        detected=marks.detected[side],
        axis=_point(truth[side]["axis_px"]),
        line=marks.lines[side],
        caption=marks.captions[side],
    )


def _white(folder: Path, image: Any) -> float:
    """Give the DN of white: of 16-bit files the scene says how many bits count."""
    from simtip.scene_file import load_scene

    if image.dtype.itemsize == 1:
        return 255.0
    try:
        return float(2 ** load_scene(folder / "scene.yaml").sensor.bit_depth - 1)
    except InputError:
        return 65535.0


def _caption(error: Any, seen: Point | None) -> str:
    if error is None:
        return "" if seen is not None else "nothing detected"
    return f"{signed(error['along'], 'px')} along, {signed(error['across'], 'px')} across"


def _point(values: Any) -> Point | None:
    if values is None:
        return None
    u, v = map(float, values)
    return (u, v) if math.isfinite(u) and math.isfinite(v) else None


def _lines(
    folder: Path, detected: Mapping[str, Point | None]
) -> dict[str, tuple[float, float, float] | None]:
    """Give both views' epipolar lines by the rig that measured; none of distorted views."""
    measured, true = folder / "rig_measured.yaml", folder / "rig_true.yaml"
    try:
        rig = read_rig(measured if measured.exists() else true)
    except InputError:
        return dict.fromkeys(SIDES)
    lines: dict[str, tuple[float, float, float] | None] = dict.fromkeys(SIDES)
    left, right = (detected[side] for side in SIDES)
    if right is not None and not len(rig.left.distortion):
        lines["left"] = _three(epipolar_line_left(right, rig))
    if left is not None and not len(rig.right.distortion):
        lines["right"] = _three(epipolar_line_right(left, rig))
    return lines


def _three(line: Array) -> tuple[float, float, float] | None:
    a, b, c = map(float, line)
    return (a, b, c) if all(map(math.isfinite, (a, b, c))) else None


def _error(result: dict[str, Any]) -> list[Part]:
    measured, true = result["tip_measured_mm"], result["tip_true_mm"]
    error = result["error_mm"]
    rows = [
        [
            axis,
            _mm(None if measured is None else measured[k]),
            _mm(true[k]),
            NONE if error is None else signed(error[axis], "mm", 4),
        ]
        for k, axis in enumerate("xyz")
    ]
    if error is not None:
        rows.append(["norm", "", "", f"{error['norm']:.4f} mm"])
    parts: list[Part] = [
        Grid(
            "Tip, left camera's frame: x right, y down, z forward",
            ["axis", "measured", "true", "error"],
            rows,
            strong=(3,),
        ),
        Grid("Tip in the images", ["view", "detected", "true", "along", "across"], _pixels(result)),
    ]
    refined = result.get("refined")
    if refined is not None:
        said = refined.get("reason") or refined.get("status")
        parts.append(Words([f"Refined: {said}."], note=True))
    return parts


def _pixels(result: dict[str, Any]) -> list[list[str]]:
    rows = []
    for side in SIDES:
        error = result["error_px"][side] or {}
        rows.append(
            [
                side,
                _px(result["tip_detected_px"][side]),
                _px(result["tip_true_px"][side]),
                signed(error.get("along"), "px"),
                signed(error.get("across"), "px"),
            ]
        )
    return rows


def _mm(value: float | None) -> str:
    return NONE if value is None else f"{value:.4f} mm"


def _px(point: Any) -> str:
    return NONE if point is None else f"{point[0]:.2f}, {point[1]:.2f}"


def _truth(truth: dict[str, Any]) -> list[Part]:
    needle = truth["needle"]
    shape = {key: value for key, value in needle["tip"].items() if key != "kind"}
    kind = " ".join([str(needle["tip"]["kind"]), *(f"{k} {v}" for k, v in shape.items())])
    rows = [
        ["tip, mm", ", ".join(f"{x:.4f}" for x in truth["tip_mm"])],
        ["axis from tip to hub", ", ".join(f"{x:.4f}" for x in truth["axis"])],
        ["needle", f"{needle['diameter_mm']:g} mm across, {needle['length_mm']:g} mm long"],
        ["point", kind],
    ]
    for side in SIDES:
        view = truth[side]
        seen = "visible" if view["tip_visible"] else "not visible"
        rows.append([f"tip in the {side} view, px", f"{_px(view['tip_px'])}, {seen}"])
        rows.append([f"its silhouette's, {side}", _px(view["silhouette_tip_px"])])
    return [Grid("What is true", ["what", "value"], rows)]


def _origin(results: Results, manifest: dict[str, Any], scene: str) -> Section:
    backend = manifest.get("backend") or {}
    noise = manifest.get("noise") or {}
    facts: dict[str, object] = {
        "folder": results.folder,
        "made": manifest.get("created_utc"),
        **versions(manifest),
        "back end": backend.get("variant"),
        "seed": manifest.get("seed"),
        "seed of the light": manifest.get("light_seed"),
        "Monte-Carlo noise asked for": noise.get("asked"),
    }
    for side in SIDES:
        median = (noise.get(side) or {}).get("needle_median")
        if median is not None:
            facts[f"that of the needle, {side}"] = f"{median:.3f} of the sensor's own"
    timings = manifest.get("timings_s") or {}
    if timings:
        facts["time"] = ", ".join(f"{name} {value:.2f} s" for name, value in timings.items())
    listed = manifest.get("sha256") or {}
    names = results.folder / "manifest.json"
    files = {name: own_file(results.folder, name, names) for name in listed}
    changed = [name for name, file in files.items() if sha256_of(file) != listed[name]]
    parts: list[Part] = []
    if changed:
        said = f"Not as they were written: {', '.join(changed)}. What is shown is what is there."
        parts.append(Words([said], note=True))
    parts.append(Code("The scene, with every default", scene, "scene.yaml", folded=True))
    return origin(results.folder, facts, [n for n, file in files.items() if file.is_file()], parts)
