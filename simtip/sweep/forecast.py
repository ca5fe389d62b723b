"""How much a sweep has to do, before it does it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from simtip.sweep.cache import Cache
from simtip.sweep.detectors import Measuring
from simtip.sweep.plan import Plan
from simtip.sweep.sizes import shown_size
from simtip.sweep.speeds import (
    IMAGES,
    LIGHT,
    USUAL_MEASURE_S,
    USUAL_S,
    known_speeds,
    measure,
    sized,
)
from simtip.sweep.stage_keys import light_key
from simtip.sweep.varying import DETECT
from simtip.sweep.work import Setup

START_S = 5.0
"""Until the first worker is at work."""

ROW_BYTES = 300
"""Of the table, a trial."""

MOST_LOOKED_AT = 2000
"""Blocks of trials whose light is worked out to count renders; of more, so many are looked at."""


def forecast(plan: Plan, setup: Setup, workers: int) -> dict[str, Any]:
    """Say how many trials, renders and images there are, and what they take.

    Returns
    -------
    forecast
        ``trials``, ``renders``, ``cached_renders``, ``images``, ``measurements`` (all different
        ones), ``seconds``, ``table_bytes``, ``cache_bytes`` (before its limit),
        ``measured_speeds``: whether this machine's were known.
    """
    megapixels = megapixels_of(plan)
    blocks = max(1, len(plan) // plan.block)
    looked = np.unique(np.linspace(0, blocks - 1, min(blocks, MOST_LOOKED_AT)).astype(int))
    keys = {_light(plan, int(block) * plan.block, setup.backend) for block in looked}
    renders = round(len(keys) * blocks / len(looked))
    images = _images(plan)
    cache = None if setup.cache is None else Cache(Path(setup.cache), setup.cache_bytes)
    known = 0 if cache is None else sum(cache.entry("light", key) is not None for key in keys)
    speeds = known_speeds(setup.cache)
    counts = _measurements(plan, images)
    size = sized(megapixels)
    measuring = sum(
        count * speeds.get(measure(label) + size, USUAL_MEASURE_S)
        for label, count in counts.items()
    )
    light_s, images_s = (speeds.get(stage + size, USUAL_S[stage]) for stage in (LIGHT, IMAGES))
    rendering = light_s * (renders - known)
    seconds = START_S + megapixels * (rendering + (images_s * images + measuring) / workers)
    groups = len(plan.base.lamps) + 1
    per_light = megapixels * 1e6 * 4 * (4 * groups + 3)
    return {
        "trials": len(plan),
        "renders": renders,
        "cached_renders": known,
        "images": images,
        "measurements": sum(counts.values()),
        "seconds": float(seconds),
        "table_bytes": ROW_BYTES * len(plan),
        "cache_bytes": int(per_light * renders + 3e6 * megapixels * images),
        "measured_speeds": {stage + size for stage in (LIGHT, IMAGES, *map(measure, counts))}
        <= set(speeds),
    }


def megapixels_of(plan: Plan) -> float:
    """Give the millions of pixels of a pair."""
    sizes = (camera.camera().size for camera in (plan.base.rig.left, plan.base.rig.right))
    return sum(width * height for width, height in sizes) / 1e6


def in_words(said: dict[str, Any]) -> str:
    """Say it in some lines."""
    whence = "as measured here" if said["measured_speeds"] else "a guess; nothing measured yet"
    found = [f"{said['rows']} rows are there already"] if said.get("rows") else []
    return "\n".join(
        [
            (
                f"{said['trials']} trials: {said['images']} pairs of images, "
                f"{said['measurements']} measurements"
            ),
            f"{said['renders']} distinct renders, {said['cached_renders']} of them in the cache",
            f"about {_duration(said['seconds'])} ({whence})",
            (
                f"about {shown_size(said['table_bytes'])} of table, "
                f"{shown_size(said['cache_bytes'])} through the cache"
            ),
            *found,
        ]
    )


def _duration(seconds: float) -> str:
    hours, rest = divmod(int(seconds + 0.5), 3600)
    minutes = rest // 60
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest % 60} s" if minutes else f"{rest} s"


def _light(plan: Plan, number: int, backend: str) -> str:
    from simtip.render.backend import VARIANTS

    variant = {str(name): variant for name, variant in VARIANTS.items()}[backend]
    return light_key(plan.reference(plan.trial(number)), variant)


def _images(plan: Plan) -> int:
    if plan.sampled:
        return plan.sizes[0] * plan.sizes[1]
    return int(np.prod(plan.sizes[: len(plan.rendered) + len(plan.mixed) + 1], dtype=np.int64))


def _measurements(plan: Plan, images: int) -> dict[str, int]:
    """Count different measurements of each detector: it may lack a parameter that varies."""
    counts = {}
    for one in plan.detectors:
        count = images
        for dimension in () if plan.sampled else plan.measured:
            if any(_tells(one, path) for path in dimension.paths):
                count *= len(dimension.levels)
        counts[one.label] = count
    return counts


def _tells(detector: Measuring, path: str) -> bool:
    """Say whether a factor makes a difference to what a detector measures."""
    if not path.startswith(DETECT):
        return path != "name"
    return detector.type_of(path.removeprefix(DETECT)) is not None
