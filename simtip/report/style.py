"""How simtip's plots look, and how they become files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

Drawn: TypeAlias = Figure
"""A figure, for those who load no plotting library."""

BLUE, ORANGE, GREEN, GRAY = "#0072B2", "#D55E00", "#009E73", "#666666"
"""Of Okabe and Ito's palette, which colour-blind people tell apart."""

SMALL = 9.5
"""Font size of what is not read first, points."""

ROOM = 52.0
"""Width of a legend above the axes of a figure of 7.5 inches, in sizes of its font."""

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


def literal(text: str) -> str:
    """Keep a user's text from being read as a formula, which a dollar would begin."""
    return text.replace("$", r"\$")


def legend_above(axes: Axes) -> None:
    """Put the legend above the axes, where no data are, in as few lines as are wide enough."""
    names = axes.get_legend_handles_labels()[1]
    if not names:
        return
    counts = [-(-len(names) // lines) for lines in range(1, len(names) + 1)]
    fitting = (count for count in counts if _width(names, count) < ROOM)
    axes.legend(
        frameon=False,
        loc="lower left",
        bbox_to_anchor=(0, 1),
        borderaxespad=0.1,
        borderpad=0.2,
        handlelength=1.6,
        columnspacing=1.5,
        fontsize=SMALL,
        ncols=next(fitting, 1),
    )


def _width(names: Sequence[str], columns: int) -> float:
    """Estimate how wide a legend is, in sizes of its font; it is filled column by column."""
    longest = [int(max(part)) for part in np.array_split([len(name) for name in names], columns)]
    return sum(4.0 + 0.55 * letters for letters in longest)


def png(figure: Figure) -> bytes:
    """Give a figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=150)
    return file.getvalue()


def svg(figure: Figure) -> bytes:
    """Give a figure as an SVG file; the same figure gives the same bytes."""
    file = io.BytesIO()
    with rc_context({"svg.hashsalt": "simtip", "svg.fonttype": "path"}):
        figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    return file.getvalue()
