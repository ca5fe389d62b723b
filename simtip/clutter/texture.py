"""The board's albedo, relief and prints over the box that the cameras see."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from simtip.clutter.coverage import coverage
from simtip.clutter.grid import Grid
from simtip.clutter.noise import Field32, field
from simtip.clutter.prints import Print, strewn
from simtip.clutter.relief import gradient_factor, slope_step_mm, slopes
from simtip.geometry import Array
from simtip.spec.background import BackgroundSpec
from simtip.spec.clutter import ClutterSpec

STEP_MM = 0.1
"""Of texels: two thirds of a pixel of the paper's cameras on the board."""

SMOOTH_STEP_MM = 2.0
"""Of texels where there is neither grain nor print: a gradient needs no more."""

MAX_SLOPES = 2_000_000


@dataclass(frozen=True, eq=False)
class BoardTexture:
    """What the board looks like; texel (j, i) is centred at ``corner + step * (i, j)``, mm.

    Coordinates are the board's own (s, t). Each value is the mean over its texel.

    Attributes
    ----------
    corner_mm, step_mm
        (2,) centre of the first texel, and the distance of the next.
    albedo
        (rows, cols) factor on the board's albedo.
    clutter
        (rows, cols) 0 to 1, how much of the texel prints cover: the truth. Paper is none of it.
    slope
        (rows', cols', 2) dh/ds and dh/dt of the height towards the cameras, at the points of its
        own grid; None where the board is flat.
    slope_corner_mm, slope_step_mm
        That grid.
    prints
        How many specks, scratches and hairs reach into the box.
    """

    corner_mm: Array
    step_mm: float
    albedo: Field32
    clutter: Field32
    slope: Field32 | None
    slope_corner_mm: Array
    slope_step_mm: float
    prints: dict[str, int]

    def to_dict(self) -> dict[str, Any]:
        """Give the truth in short, for ``truth.json``."""
        high = self.corner_mm + self.step_mm * np.array(self.albedo.shape[::-1])
        return {
            "low_mm": (self.corner_mm - self.step_mm / 2).tolist(),
            "high_mm": (high - self.step_mm / 2).tolist(),
            "prints": dict(self.prints),
            "printed_share": float(self.clutter.mean(dtype=np.float64)),
        }


def board_texture(
    background: BackgroundSpec,
    clutter: ClutterSpec,
    seed: int,
    low_mm: ArrayLike,
    high_mm: ArrayLike,
    *,
    step_mm: float = STEP_MM,
) -> BoardTexture | None:
    """Make the board's texture over a box.

    Values belong to places: two boxes of one step agree, bit for bit, where they overlap.

    Parameters
    ----------
    background, clutter
        The board and what is strewn on it.
    seed
        The scene's; `background.texture_seed` and `clutter.seed` stand above it.
    low_mm, high_mm
        (2,) the box, board coordinates; what lies off the board is left out.
    step_mm
        Finest texel; a box of more than ten million gets larger ones.

    Returns
    -------
    texture
        None where the board is plain, or the box beside it.

    Raises
    ------
    InputError
        The box is too large for what is to be seen on it.
    """
    half = np.array(background.size_mm) / 2
    low = np.maximum(np.asarray(low_mm, dtype=np.float64), -half)
    high = np.minimum(np.asarray(high_mm, dtype=np.float64), half)
    amounts, sheet = clutter.amounts(), _sheet(background, seed)
    wrinkles = background.wrinkles
    plain = not (background.textured() or wrinkles or amounts.prints())
    if plain or not (low < high).all():
        return None
    fine = background.paper is not None or amounts.prints()
    grid = Grid.over(low, high, step_mm if fine else max(step_mm, SMOOTH_STEP_MM))
    albedo = paper_albedo(background, sheet, grid, half)
    which = seed if clutter.seed is None else clutter.seed
    covered, counts = draw(albedo, grid, strewn(amounts, which, low, high))
    slope, slope_grid = None, grid
    if wrinkles is not None:
        slope_grid = Grid.over(low, high, slope_step_mm(wrinkles), MAX_SLOPES)
        slope = slopes(wrinkles, sheet, slope_grid, half)
    return BoardTexture(
        corner_mm=grid.corner_mm,
        step_mm=grid.step_mm,
        albedo=albedo,
        clutter=covered,
        slope=slope,
        slope_corner_mm=slope_grid.corner_mm,
        slope_step_mm=slope_grid.step_mm,
        prints=counts,
    )


def paper_albedo(background: BackgroundSpec, seed: int, grid: Grid, half_mm: Array) -> Field32:
    """Give the factor (rows, cols) of grain, cloudiness and gradient, of mean 1 over the board."""
    factor = np.ones(grid.shape, dtype=np.float32)
    if paper := background.paper:
        for name, contrast, length in (
            ("grain", paper.contrast, paper.correlation_mm),
            ("mottle", paper.mottle_contrast, paper.mottle_mm),
        ):
            if contrast:
                values = field(seed, name, grid, length)
                values *= contrast
                factor += values
    if background.gradient:
        factor *= gradient_factor(background.gradient, grid, half_mm)
    if background.textured():
        brightest = 1 / max(*background.albedo, 1e-9)
        np.clip(factor, 0, brightest, out=factor)
    return factor


def draw(albedo: Field32, grid: Grid, prints: Any) -> tuple[Field32, dict[str, int]]:
    """Darken an albedo (rows, cols) in place by prints.

    A print of contrast c that covers a share a of a texel multiplies its albedo by 1 - a c.

    Returns
    -------
    covered
        (rows, cols) share of each texel under prints; those of different prints overlap at random.
    counts
        Of each kind, those that lie in the box.
    """
    bare = np.ones(grid.shape, dtype=np.float32)
    counts = Counter({"speck": 0, "scratch": 0, "hair": 0})
    for item in prints:
        if grid.reaches(item.outline.min(axis=0), item.outline.max(axis=0)):
            counts[item.kind] += _stamp(albedo, bare, grid, item)
    return np.subtract(1, bare, out=bare), dict(counts)


def _stamp(albedo: Field32, bare: Field32, grid: Grid, item: Print) -> bool:
    """Draw one print; say whether any of it fell into the box."""
    rows, cols = grid.shape
    hit = False
    for patch in coverage(grid.cells(item.outline)):
        y, x = patch.row - grid.first[1], patch.col - grid.first[0]
        h, w = patch.share.shape
        top, left, bottom, right = max(y, 0), max(x, 0), min(y + h, rows), min(x + w, cols)
        if top >= bottom or left >= right:
            continue
        share = patch.share[top - y : bottom - y, left - x : right - x]
        albedo[top:bottom, left:right] *= 1 - item.contrast * share
        bare[top:bottom, left:right] *= 1 - share
        hit = hit or bool(share.any())
    return hit


def _sheet(background: BackgroundSpec, seed: int) -> int:
    return seed if background.texture_seed is None else background.texture_seed
