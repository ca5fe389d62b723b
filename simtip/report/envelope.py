"""Errors over two factors, and where a measurement may be trusted: the operating envelope."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.figure import Figure
from numpy.typing import NDArray

from simtip.geometry import Array
from simtip.report.scale import LEAST, Scale, scale_for
from simtip.report.style import SMALL, literal, new_figure

MOST_WRITTEN = 300
"""Cells; in more there is no room for numbers."""

LONGEST = 24

USUAL, FAR = 0.96, 1.8
"""The quantile beyond which numbers may share a colour, and how far above it the largest is."""

DARK = 0.5
"""Of the colours, above which writing is white."""


@dataclass(frozen=True, eq=False)
class Envelope:
    """A figure over two factors, cell by cell.

    Attributes
    ----------
    title
        What the numbers are.
    factors
        Names of the factor across and of that upwards.
    across, up
        Their levels, in order.
    error_mm
        (up, across) of each cell; NaN where no tip was found.
    rate
        (up, across) share of trials with a tip; NaN where there was no trial.
    limit_mm
        Largest error within the envelope.
    """

    title: str
    factors: tuple[str, str]
    across: Sequence[str]
    up: Sequence[str]
    error_mm: Array
    rate: Array
    limit_mm: float

    @property
    def inside(self) -> NDArray[np.bool_]:
        """(up, across) cells in which every trial has a tip and the error is within the limit."""
        with np.errstate(invalid="ignore"):
            return np.asarray((self.rate == 1) & (self.error_mm <= self.limit_mm))


def envelope_figure(found: Envelope) -> Figure:
    """Draw the cells, and a line around those of the envelope."""
    rows, columns = found.error_mm.shape
    figure = new_figure(min(12.0, 3.2 + 0.55 * columns), min(9.0, 2.0 + 0.36 * rows))
    axes = figure.subplots()
    known = found.error_mm[np.isfinite(found.error_mm)]
    scale = scale_for(known if len(known) else [0.0])
    shown = np.ma.masked_invalid(scale.of(found.error_mm))
    most, cut = _most(scale.of(known))
    mesh = axes.pcolormesh(shown, cmap="viridis_r", edgecolors="white", lw=0.6, vmax=most)
    if rows * columns <= MOST_WRITTEN:
        _numbers(axes, found, scale, mesh)
    lines = _outline(found.inside)
    for color, width in (("white", 5.0), ("black", 2.2)):
        edge = LineCollection(lines, colors=color, lw=width, capstyle="round", clip_on=False)
        axes.add_collection(edge)
    axes.set_xticks(np.arange(columns) + 0.5, _cut(found.across))
    axes.set_yticks(np.arange(rows) + 0.5, _cut(found.up))
    if max(map(len, found.across)) > 6:
        for label in axes.get_xticklabels():
            label.set(rotation=40, ha="right")
    axes.tick_params(length=0, labelsize=SMALL)
    axes.set_xlabel(literal(found.factors[0]))
    axes.set_ylabel(literal(found.factors[1]))
    axes.spines[:].set_visible(False)
    limit = scale_for([found.limit_mm]).text(found.limit_mm)
    axes.set_title(
        literal(f"{found.title}; outlined: every trial has a tip, and it is at most {limit}"),
        fontsize=10,
        loc="left",
    )
    figure.colorbar(mesh, ax=axes, label=f"error, {scale.unit}", shrink=0.9, extend=cut)
    return figure


def _most(shown: Array) -> tuple[float | None, Literal["neither", "max"]]:
    """Give where the colours end: a few numbers far above all others share the last."""
    if not len(shown):
        return None, "neither"
    usual = float(np.quantile(shown, USUAL))
    if shown.max() > FAR * usual > FAR * shown.min():
        return usual, "max"
    return None, "neither"


def _numbers(axes: Axes, found: Envelope, scale: Scale, mesh: QuadMesh) -> None:
    low, high = mesh.get_clim()
    low, high = (0.0, 1.0) if low is None or high is None else (low, high)
    for (row, column), value in np.ndenumerate(found.error_mm):
        if np.isfinite(value):
            text = scale.number(value)
            shade = (scale.factor * value - low) / max(high - low, LEAST)
            color = "white" if shade > DARK else "black"
        elif np.isfinite(found.rate[row, column]):
            text, color = "\N{MULTIPLICATION SIGN}", "#666666"
        else:
            continue
        axes.text(
            column + 0.5, row + 0.5, text, ha="center", va="center", fontsize=7.5, color=color
        )


def _outline(inside: NDArray[np.bool_]) -> list[list[tuple[float, float]]]:
    """Give the edges that only one of two neighbours has."""
    padded = np.pad(inside, 1)
    lines = []
    for row, column in zip(*np.nonzero(padded), strict=True):
        v, u = float(row - 1), float(column - 1)
        if not padded[row - 1, column]:
            lines.append([(u, v), (u + 1, v)])
        if not padded[row + 1, column]:
            lines.append([(u, v + 1), (u + 1, v + 1)])
        if not padded[row, column - 1]:
            lines.append([(u, v), (u, v + 1)])
        if not padded[row, column + 1]:
            lines.append([(u + 1, v), (u + 1, v + 1)])
    return lines


def _cut(labels: Sequence[str]) -> list[str]:
    return [
        literal(label if len(label) <= LONGEST else f"{label[: LONGEST - 2]}..") for label in labels
    ]
