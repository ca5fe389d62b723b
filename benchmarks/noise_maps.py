"""Maps of relative noise as one picture: whole views above, the part around the needle below."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

RANGE = (1e-4, 1.0)
TICKS = {1e-4: "0.01 %", 1e-3: "0.1 %", 5e-3: "0.5 %", 1e-2: "1 %", 1e-1: "10 %", 1.0: "100 %"}


def draw(
    path: Path,
    maps: dict[str, NDArray[np.float32]],
    window: tuple[int, int, int, int],
    seeds: int,
) -> None:
    """Write a PNG.

    Parameters
    ----------
    path
        Where.
    maps
        By title: (H, W) standard deviation over mean.
    window
        The part that is shown enlarged: x, y, width, height.
    seeds
        From how many pictures the maps were made.
    """
    x, y, width, height = window
    figure = Figure(figsize=(12, 9), layout="constrained")
    axes = figure.subplots(2, len(maps), height_ratios=[1, 1.2], squeeze=False)
    look = {"cmap": colormaps["viridis"], "norm": LogNorm(*RANGE), "interpolation": "nearest"}
    for (title, noise), (whole, part) in zip(maps.items(), axes.T, strict=True):
        shown = np.clip(noise, *RANGE)
        picture = whole.imshow(shown, **look)
        whole.add_patch(Rectangle((x, y), width, height, fill=False, color="red"))
        whole.set_title(title)
        extent = (x - 0.5, x + width - 0.5, y + height - 0.5, y - 0.5)
        part.imshow(shown[y : y + height, x : x + width], extent=extent, **look)
        part.set_title("the part in red")
        for axis in (whole, part):
            axis.set_xlabel("u, px")
            axis.set_ylabel("v, px")
    bar = figure.colorbar(picture, ax=axes, shrink=0.8, ticks=list(TICKS))
    bar.ax.set_yticklabels(list(TICKS.values()))
    bar.set_label(f"standard deviation over {seeds} seeds / mean")
    FigureCanvasAgg(figure).print_png(str(path))
