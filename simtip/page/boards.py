"""The page of calibration images."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from simtip.errors import InputError
from simtip.image_file import read_image
from simtip.page.folder import Results, TakenFrom, own_file
from simtip.page.origin import origin, versions
from simtip.page.parts import Code, Fact, Grid, Layer, Page, Part, Section, View, Views, Words
from simtip.page.pictures import as_8_bit, overview

SIDES = ("left", "right")
MOST_SHOWN = 12
"""Pairs of images; the page would be large with more."""
OVERVIEW_PX = 900


def boards_page(results: Results) -> Page:
    """Make the page of a folder of `boards`, also of one that is not filled up yet."""
    truth = results.json("truth.json")
    with TakenFrom(results.folder / "truth.json"):
        return _page(results, truth)


def _page(results: Results, truth: dict[str, Any]) -> Page:
    views = truth["views"]
    there = [view for view in views if _is_there(results, view)]
    shown = there[:MOST_SHOWN]
    missing = len(views) - len(there)
    verdict = f"{len(views)} views of {truth['target']} with known truth."
    if missing:
        verdict += f" {missing} are not rendered yet: the same command goes on."
    parts: list[Part] = []
    if len(there) > len(shown):
        parts.append(Words([f"The first {len(shown)} of {len(there)} views."], note=True))
    parts += [
        Views(f"view {view['name']}", [_view(results, view, side, truth) for side in SIDES])
        for view in shown
    ]
    sections = [Section("views", "Views", _coverage(views))]
    if shown:
        sections.append(Section("images", "Images", parts))
    sections.append(_origin(results, truth, there))
    title = f"Calibration images of {truth['target']}"
    return Page(title, "boards", verdict, list(_facts(truth, there)), sections)


def _is_there(results: Results, view: dict[str, Any]) -> bool:
    return all(_file(results, view, side).is_file() for side in SIDES)


def _file(results: Results, view: dict[str, Any], side: str) -> Path:
    return own_file(results.folder, view[side]["file"], results.folder / "truth.json")


def _facts(truth: dict[str, Any], there: list[dict[str, Any]]) -> Iterator[Fact]:
    yield Fact("Views", str(len(there)), f"of {len(truth['views'])}")
    yield Fact("Points", str(len(truth["plate"]["points_mm"])), "on the target")
    for side in SIDES:
        width, height = truth["image_size"][side]
        yield Fact(f"{side.title()} images", f"{width} x {height}", "px")
    bow = truth["plate"]["bow_mm"]
    if bow:
        yield Fact("Bow of the plate", f"{bow:g} mm")


def _coverage(views: list[dict[str, Any]]) -> list[Part]:
    rows = []
    for view in views:
        seen = [view[side].get("visible") for side in SIDES]
        counts = ["" if one is None else str(sum(map(bool, one))) for one in seen]
        rows.append([str(view["name"]), *counts, ", ".join(f"{x:.1f}" for x in view["t_mm"])])
    heads = ["view", "points in left", "points in right", "place of the target's origin, mm"]
    return [Grid("What each view shows", heads, rows)]


def _view(results: Results, view: dict[str, Any], side: str, truth: dict[str, Any]) -> View:
    file = _file(results, view, side)
    image = read_image(file)
    white = 255 if image.dtype.itemsize == 1 else float(image.max() or 1)
    layer: Layer = overview(as_8_bit(image, white), OVERVIEW_PX)
    height, width = image.shape[:2]
    expected = tuple(truth["image_size"][side])
    if (width, height) != expected:
        raise InputError(
            f"has {width} x {height} px, not {expected[0]} x {expected[1]} as truth.json says",
            file=file,
            remedy="restore it, or render the boards again",
        )
    whole = (-0.5, -0.5, float(width), float(height))
    return View(f"{side} {view['name']}", width, height, [layer], whole)


def _origin(results: Results, truth: dict[str, Any], there: list[dict[str, Any]]) -> Section:
    made = truth.get("made_by") or {}
    backend = made.get("backend") or {}
    facts = {
        "folder": results.folder,
        **versions(made),
        "back end": backend.get("variant"),
        "seed": truth.get("seed"),
        "inputs (SHA-256)": truth.get("inputs_sha256"),
        "plate": json.dumps({k: v for k, v in truth["plate"].items() if k != "points_mm"}),
    }
    names = [_file(results, view, side).name for view in there for side in SIDES]
    files = ["truth.json", *names]
    scene = results.text("scene.yaml")
    more = [Code("The scene, with every default", scene, "scene.yaml", folded=True)]
    return origin(results.folder, facts, files, more)
