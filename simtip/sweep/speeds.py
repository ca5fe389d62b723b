"""What the stages of trials take on this machine, kept in the cache's folder for later forecasts.

Kept for images of about one size: a few pixels say little of what many take.
"""

from __future__ import annotations

import json
import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

from simtip.errors import InputError
from simtip.output_folder import write_atomically

FILE = "speeds.json"

LIGHT, IMAGES = "light", "images"
USUAL_S = {LIGHT: 3.0, IMAGES: 0.1}
"""Per million pixels of a pair where nothing was measured yet: two cores, the paper's scene."""

USUAL_MEASURE_S = 0.02

MOST_KEPT = 1000

Row = Mapping[str, object]


class Spent:
    """Time spent in stages, by stage: light, images, and what each detector measures."""

    def __init__(self) -> None:
        self._sums: defaultdict[str, float] = defaultdict(float)
        self._counts: Counter[str] = Counter()

    def add(self, rows: Iterable[Row]) -> None:
        """Take note of rows of the table."""
        for row in rows:
            self._add(LIGHT, row.get("render_s"))
            self._add(IMAGES, row.get("sensor_s"))
            self._add(measure(str(row.get("detector"))), row.get("detect_s"))

    def _add(self, stage: str, seconds: object) -> None:
        if isinstance(seconds, float):
            self._sums[stage] += seconds
            self._counts[stage] += 1

    def means(self, megapixels: float) -> dict[str, float]:
        """Give the mean of each stage, s per million pixels of a pair, for pairs of that size."""
        return {
            stage + sized(megapixels): self._sums[stage] / count / megapixels
            for stage, count in self._counts.items()
        }


def sized(megapixels: float) -> str:
    """Name pairs of about that size, within a factor of 1.4."""
    return f" at {2.0 ** round(math.log2(megapixels)):g} Mpx"


def measure(label: str) -> str:
    """Name the stage of measurements with a detector."""
    return f"measure by {label}"


def known_speeds(cache: str | None) -> dict[str, float]:
    """Read what was kept; nothing if there is nothing, or it is damaged."""
    if cache is None:
        return {}
    try:
        said = json.loads((Path(cache) / FILE).read_text(encoding="utf-8"))
        pairs = {str(name): float(value) for name, value in said.items()}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}
    return {name: value for name, value in pairs.items() if math.isfinite(value) and value > 0}


def keep_speeds(cache: str | None, now: Mapping[str, float]) -> None:
    """Keep what was measured now, beside what else is known; a cache that cannot, does not."""
    if cache is None or not now:
        return
    both = {**known_speeds(cache), **now}
    kept = dict(list(both.items())[-MOST_KEPT:])
    try:
        write_atomically(Path(cache) / FILE, json.dumps(kept).encode())
    except InputError:
        return
