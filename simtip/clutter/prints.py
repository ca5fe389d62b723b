"""Specks, scratches and hairs on the board: outlines strewn by tiles of 100 cm2.

Each tile draws from a stream of its own, so what lies at a place depends on neither the box that is
asked for nor the board's size. Board coordinates (s, t), mm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.clutter.coverage import area
from simtip.errors import InputError
from simtip.geometry import Array
from simtip.seeding import stream
from simtip.spec.clutter import ClutterAmounts, Range

TILE_MM = 100.0
MAX_TILES = 4096
MAX_SPECK_MM = 20.0
CORNERS = 32
"""Of a speck's outline."""

JOINTS = 24
"""Of a hair or scratch."""


@dataclass(frozen=True, eq=False)
class Print:
    """One thing on the board.

    Attributes
    ----------
    kind
        "speck", "scratch" or "hair".
    outline
        (n, 2) corners, mm.
    contrast
        How much darker than the board, 0 to 1.
    """

    kind: str
    outline: Array
    contrast: float

    @property
    def area_mm2(self) -> float:
        """Of the outline."""
        return abs(area(self.outline))


def tiles(low_mm: Array, high_mm: Array, reach_mm: float = 0.0) -> Iterator[tuple[int, int]]:
    """Give (j, i) of the tiles that things within reach of a box may be centred in.

    Raises
    ------
    InputError
        The box is so large that its clutter could not be seen one by one.
    """
    i0, j0 = np.floor((np.asarray(low_mm) - reach_mm) / TILE_MM).astype(int)
    i1, j1 = np.floor((np.asarray(high_mm) + reach_mm) / TILE_MM).astype(int)
    if (i1 - i0 + 1) * (j1 - j0 + 1) > MAX_TILES:
        raise InputError(
            f"the cameras see {(high_mm - low_mm)[0]:.0f} x {(high_mm - low_mm)[1]:.0f} mm of the "
            "board, too much to strew with clutter",
            field="background.size_mm",
            remedy="make the board smaller",
        )
    for j in range(j0, j1 + 1):
        for i in range(i0, i1 + 1):
            yield j, i


def strewn(amounts: ClutterAmounts, seed: int, low_mm: Array, high_mm: Array) -> Iterator[Print]:
    """Give all prints that may touch a box of the board, always in the same order."""
    makers: tuple[tuple[str, float, float, Callable[..., Iterator[Print]]], ...] = (
        ("speck", amounts.specks_per_100cm2, MAX_SPECK_MM, _specks),
        ("scratch", amounts.scratches_per_100cm2, amounts.scratch_mm[1], _scratches),
        ("hair", amounts.hairs_per_100cm2, amounts.hair_mm[1], _hairs),
    )
    for kind, density, reach, make in makers:
        if density == 0:
            continue
        for j, i in tiles(low_mm, high_mm, reach):
            rng = stream(seed, "clutter", kind, j, i)
            count = int(rng.poisson(density))
            centres = (np.array([i, j]) + rng.random((count, 2))) * TILE_MM
            yield from make(amounts, rng, centres)


def lognormal(rng: np.random.Generator, median: float, sigma: float, count: int) -> Array:
    """Draw diameters (count,), mm, none above the largest speck."""
    return np.minimum(rng.lognormal(math.log(median), sigma, count), MAX_SPECK_MM)


def between(rng: np.random.Generator, ends: Range, count: int | None = None) -> Any:
    """Draw uniformly between two ends."""
    return rng.uniform(ends[0], ends[1], count)


def _between_logs(rng: np.random.Generator, ends: Range, count: int) -> Array:
    return np.exp(rng.uniform(math.log(ends[0]), math.log(ends[1]), count))


def _specks(amounts: ClutterAmounts, rng: np.random.Generator, centres: Array) -> Iterator[Print]:
    """Make blobs: discs that are stretched and dented, of the area of the disc."""
    n = len(centres)
    diameter = lognormal(rng, amounts.speck_mm, amounts.speck_sigma, n)
    stretch = np.exp(np.abs(rng.normal(0, 0.25, n)))
    turn = rng.uniform(0, np.pi, n)
    waves = np.arange(2, 7)
    depth = rng.normal(0, 0.22, (n, len(waves))) / waves
    phase = rng.uniform(0, 2 * np.pi, (n, len(waves)))
    contrast = between(rng, amounts.contrast, n)
    angle = 2 * np.pi * np.arange(CORNERS) / CORNERS
    ripple = (depth[:, :, None] * np.cos(waves[:, None] * angle + phase[:, :, None])).sum(axis=1)
    radius = np.maximum(1 + ripple, 0.25)
    x = radius * np.cos(angle) * np.sqrt(stretch)[:, None]
    y = radius * np.sin(angle) / np.sqrt(stretch)[:, None]
    c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
    blobs = np.stack([c * x - s * y, s * x + c * y], axis=-1)
    for k in range(n):
        scale = diameter[k] / 2 * math.sqrt(math.pi / abs(area(blobs[k])))
        yield Print("speck", centres[k] + scale * blobs[k], float(contrast[k]))


def _scratches(
    amounts: ClutterAmounts, rng: np.random.Generator, centres: Array
) -> Iterator[Print]:
    """Make lines that hardly bend and taper to both ends."""
    n = len(centres)
    length = _between_logs(rng, amounts.scratch_mm, n)
    width = _between_logs(rng, amounts.scratch_width_mm, n)
    start = rng.uniform(0, 2 * np.pi, n)
    bend = rng.normal(0, 0.1, n)
    contrast = between(rng, amounts.scratch_contrast, n)
    u = np.linspace(0, 1, JOINTS + 1)
    # Half widths whose mean over the length is half the width: the area is length times width.
    profile = np.sin(np.pi * u) ** 0.5
    profile *= 0.5 / np.trapezoid(profile, u)
    for k in range(n):
        heading = start[k] + bend[k] * (u - 0.5)
        outline = _line(centres[k], heading, length[k], width[k] * profile)
        yield Print("scratch", outline, float(contrast[k]))


def _hairs(amounts: ClutterAmounts, rng: np.random.Generator, centres: Array) -> Iterator[Print]:
    """Make thin curls: a mean curvature and two waves on it."""
    n = len(centres)
    length = _between_logs(rng, amounts.hair_mm, n)
    width = _between_logs(rng, amounts.hair_width_mm, n)
    start = rng.uniform(0, 2 * np.pi, n)
    curl = rng.normal(0, 1.6, n)
    wave = rng.normal(0, [0.6, 0.25], (n, 2))
    phase = rng.uniform(0, 2 * np.pi, (n, 2))
    contrast = between(rng, amounts.contrast, n)
    u = np.linspace(0, 1, JOINTS * 2 + 1)
    half = np.full(len(u), 0.5)
    for k in range(n):
        turns = wave[k] * np.sin(np.outer(u, [5.0, 13.0]) + phase[k])
        heading = start[k] + curl[k] * u + turns.sum(axis=1)
        outline = _line(centres[k], heading, length[k], width[k] * half)
        yield Print("hair", outline, float(contrast[k]))


def _line(centre: Array, heading: Array, length: float, half: Array) -> Array:
    """Give the outline (2 n, 2) of a line whose heading (n,) and half width (n,) change."""
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    step = length / (len(heading) - 1)
    spine = np.concatenate([[[0.0, 0.0]], np.cumsum((ahead[1:] + ahead[:-1]) / 2, axis=0) * step])
    spine += centre - (spine.min(axis=0) + spine.max(axis=0)) / 2
    across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) * half[:, None]
    return np.concatenate([spine + across, (spine - across)[::-1]])
