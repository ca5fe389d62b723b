"""How simtip's plots look, and how they become files."""

from __future__ import annotations

import io

from matplotlib.axes import Axes
from matplotlib.figure import Figure

BLUE, ORANGE, GREEN, GRAY = "#0072B2", "#D55E00", "#009E73", "#666666"
"""Of Okabe and Ito's palette, which colour-blind people tell apart."""

SIDES = {"left": BLUE, "right": ORANGE}


def new_figure(width: float, height: float) -> Figure:
    """Make an empty figure, inches."""
    return Figure(figsize=(width, height), layout="constrained")


def plain(axes: Axes, *, grid: bool = True) -> None:
    """Take away what is not needed around a plot."""
    axes.spines[["top", "right"]].set_visible(False)
    if grid:
        axes.grid(alpha=0.25)
        axes.set_axisbelow(True)


def png(figure: Figure) -> bytes:
    """Give a figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=150)
    return file.getvalue()
