"""Slopes of a wrinkled board, and the smooth change of its albedo."""

from __future__ import annotations

import numpy as np

from simtip.clutter.grid import Grid
from simtip.clutter.noise import Field32, field
from simtip.geometry import Array
from simtip.seeding import stream
from simtip.spec.background import Gradient, Wrinkles

FOLD_WIDTH_MM = 0.8
"""Half of the rounded back of a crease."""

FOLD_DECAY_MM = 18.0
"""The paper lies flat again so far from a crease, to 1/e."""


def slope_step_mm(wrinkles: Wrinkles) -> float:
    """Give a grid step, mm, on which linear interpolation of the slope is good to 1 %."""
    return FOLD_WIDTH_MM / 2 if wrinkles.folds else min(wrinkles.scale_mm / 16, 2.0)


def slopes(wrinkles: Wrinkles, seed: int, grid: Grid, half_mm: Array) -> Field32:
    """Give the height's derivatives along s and t, (rows, cols, 2), mm/mm.

    Parameters
    ----------
    wrinkles
        What there is.
    seed
        Which sheet.
    grid
        The points.
    half_mm
        (2,) half the board's sides: creases run through a point of the board.
    """
    found = np.zeros((*grid.shape, 2), dtype=np.float32)
    if wrinkles.rms_slope:
        undulation = field(seed, "wrinkles", grid, wrinkles.scale_mm, slopes=True)
        found += undulation * (wrinkles.rms_slope * wrinkles.scale_mm / 2)
    s, t = grid.axes()
    for k in range(wrinkles.folds):
        rng = stream(seed, "board", "fold", k)
        through = rng.uniform(-half_mm, half_mm)
        # Sheets are folded about parallel to their sides.
        angle = rng.normal(0, 0.15) + (np.pi / 2 if rng.random() < 0.5 else 0)
        across = np.array([np.cos(angle), np.sin(angle)])
        side = 1 if rng.random() < 0.5 else -1  # a ridge or a valley
        d = (s - through[0]) * across[0] + (t[:, None] - through[1]) * across[1]
        profile = np.tanh(d / FOLD_WIDTH_MM) * np.exp(-np.abs(d) / FOLD_DECAY_MM)
        found += (side * wrinkles.fold_slope * profile[..., None] * across).astype(np.float32)
    return found


def gradient_factor(gradient: Gradient, grid: Grid, half_mm: Array) -> Field32:
    """Give the factor on the albedo, (rows, cols), whose mean over the board is 1."""
    s, t = grid.axes()
    if gradient.kind == "vignette":
        squared = (s**2 + t[:, None] ** 2) / (half_mm @ half_mm)
        # The mean of `squared` over a rectangle is 1/3.
        factor = (1 + (gradient.ratio - 1) * squared) * 3 / (2 + gradient.ratio)
    else:
        angle = np.radians(gradient.direction_deg)
        towards = np.array([np.cos(angle), np.sin(angle)])
        span = gradient.span_mm or 2 * float(np.abs(towards) @ half_mm)
        x = (s * towards[0] + t[:, None] * towards[1]) * (2 / span)
        factor = 1 + gradient.swing() * np.clip(x, -1, 1)
    return np.asarray(factor, dtype=np.float32)
