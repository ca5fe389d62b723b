"""How much a sweep has to do, before it does it."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from simtip.output_folder import write_atomically
from simtip.sweep.cache import Cache
from simtip.sweep.plan import Plan
from simtip.sweep.sizes import shown_size
from simtip.sweep.stage_keys import light_key
from simtip.sweep.table import Table
from simtip.sweep.work import Setup

SPEEDS = "speeds.json"
"""In the cache's folder: what the stages took here, s per million pixels of a pair."""

USUAL_S = {"light": 4.0, "images": 0.1, "measure": 0.1}
"""The same where nothing was measured yet: two cores of 2020, the paper's scene."""

ROW_BYTES = 300
"""Of the table, a trial."""

MOST_LOOKED_AT = 2000
"""Blocks of trials whose light is worked out to count renders; of more, so many are looked at."""


def forecast(plan: Plan, setup: Setup, workers: int) -> dict[str, Any]:
    """Say how many trials, renders and images there are, and what they take.

    Returns
    -------
    forecast
        ``trials``, ``renders``, ``cached_renders``, ``images``, ``seconds``, ``table_bytes``,
        ``cache_bytes`` (before its limit), ``measured_speeds``: whether this machine's were known.
    """
    megapixels = _megapixels(plan)
    blocks = max(1, len(plan) // plan.block)
    looked = np.unique(np.linspace(0, blocks - 1, min(blocks, MOST_LOOKED_AT)).astype(int))
    keys = {_light(plan, int(block) * plan.block) for block in looked}
    renders = round(len(keys) * blocks / len(looked))
    images = _images(plan)
    cache = None if setup.cache is None else Cache(Path(setup.cache), setup.cache_bytes)
    known = 0 if cache is None else sum(cache.entry("light", key) is not None for key in keys)
    speeds, measured = _speeds(setup)
    seconds = megapixels * (
        speeds["light"] * (renders - known)
        + (speeds["images"] * images + speeds["measure"] * len(plan)) / workers
    )
    groups = len(plan.base.lamps) + 1
    per_light = megapixels * 1e6 * 4 * (4 * groups + 3)
    return {
        "trials": len(plan),
        "renders": renders,
        "cached_renders": known,
        "images": images,
        "seconds": float(seconds),
        "table_bytes": ROW_BYTES * len(plan),
        "cache_bytes": int(per_light * renders + 3e6 * megapixels * images),
        "measured_speeds": measured,
    }


def _megapixels(plan: Plan) -> float:
    """Give the millions of pixels of a pair."""
    sizes = (camera.camera().size for camera in (plan.base.rig.left, plan.base.rig.right))
    return sum(width * height for width, height in sizes) / 1e6


def in_words(said: dict[str, Any]) -> str:
    """Say it in some lines."""
    hours, rest = divmod(int(said["seconds"]), 3600)
    whence = "as measured here" if said["measured_speeds"] else "a guess; nothing measured yet"
    return "\n".join(
        [
            f"{said['trials']} trials of {said['images']} pairs of images",
            f"{said['renders']} distinct renders, {said['cached_renders']} of them in the cache",
            f"about {hours} h {rest // 60} min ({whence})",
            (
                f"about {shown_size(said['table_bytes'])} of table, "
                f"{shown_size(said['cache_bytes'])} through the cache"
            ),
        ]
    )


def _light(plan: Plan, number: int) -> str:
    from simtip.render.backend import VARIANTS, choose

    return light_key(plan.reference(plan.trial(number)), VARIANTS[choose().name])


def _images(plan: Plan) -> int:
    if plan.sampled:
        return plan.sizes[0] * plan.sizes[1]
    return int(np.prod(plan.sizes[: len(plan.rendered) + len(plan.mixed) + 1], dtype=np.int64))


def _speeds(setup: Setup) -> tuple[dict[str, float], bool]:
    if setup.cache is None:
        return USUAL_S, False
    try:
        said = json.loads((Path(setup.cache) / SPEEDS).read_text(encoding="utf-8"))
        known = {name: float(said[name]) for name in USUAL_S}
    except (OSError, ValueError, KeyError, TypeError):
        return USUAL_S, False
    return known, all(np.isfinite(value) and value > 0 for value in known.values())


def remember_speeds(plan: Plan, setup: Setup, table: Table) -> None:
    """Keep what the stages took, for later forecasts."""
    if setup.cache is None:
        return
    found: dict[str, list[float]] = {"render_s": [], "sensor_s": [], "detect_s": []}
    for rows in table.batches():
        for name, values in found.items():
            values.extend(value for row in rows if isinstance(value := row[name], float))
    before, _ = _speeds(setup)
    names = zip(USUAL_S, found.values(), strict=True)
    now = {
        name: float(np.median(values)) / _megapixels(plan) if values else before[name]
        for name, values in names
    }
    if os.access(setup.cache, os.W_OK):
        write_atomically(Path(setup.cache) / SPEEDS, json.dumps(now).encode())
