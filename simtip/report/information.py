"""Where in an image the information about the tip's place sits."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from simtip.bound import InformationMap
from simtip.geometry import Array
from simtip.report.style import ORANGE, new_figure, png

DECADES = 4
"""Of information that the colours span."""
ZOOM_PX = 36
"""Half the side of the close-up."""
WINDOW_PX = 25
"""Around the band in the wide picture."""


def plot_information(found: InformationMap, side: str) -> bytes:
    """Draw one view's maps, along and across, wide and close up, as a PNG file.

    The share of all information that lies nearer to the tip than a distance stands beside.
    """
    figure = new_figure(12, 8.6)
    axes = figure.subplot_mosaic(
        [["image", "along", "across"], ["share", "along_near", "across_near"]],
        height_ratios=[1.25, 1],
    )
    figure.suptitle(
        f"{side} view: information of each pixel about the tip's place in the image, px$^{{-2}}$",
        fontsize=12,
    )
    _image(axes["image"], found)
    for name, layer in (("along", found.along), ("across", found.across)):
        norm = LogNorm(layer.max() / 10**DECADES, layer.max())
        mesh = _layer(axes[name], found, layer, norm)
        _layer(axes[f"{name}_near"], found, layer, norm)
        _wide(axes[name], found)
        _near(axes[f"{name}_near"], found)
        deviation = 1 / np.sqrt(layer.sum())
        axes[name].set_title(f"{name} the axis; all together: {deviation:.2g} px", fontsize=10)
        axes[f"{name}_near"].set_title(f"{name}, at the tip", fontsize=10)
        figure.colorbar(mesh, ax=[axes[name], axes[f"{name}_near"]], shrink=0.6)
    _share(axes["share"], found)
    return png(figure)


def _extent(found: InformationMap) -> tuple[float, float, float, float]:
    (u, v), (height, width) = found.corner_px, found.image.shape
    return u - 0.5, u + width - 0.5, v + height - 0.5, v - 0.5


def _image(axes: Axes, found: InformationMap) -> None:
    axes.imshow(found.image, cmap="gray", vmin=0, extent=_extent(found), interpolation="nearest")
    _mark(axes, found)
    width, height = found.size_px
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), facecolor="0.92")
    axes.set_title("what was looked at of the image", fontsize=10)
    axes.set(xlabel="u, px", ylabel="v, px")


def _layer(axes: Axes, found: InformationMap, layer: Array, norm: LogNorm) -> Any:
    shown = np.where(layer > 0, layer, np.nan)
    axes.set_facecolor("black")
    mesh = axes.imshow(
        shown, cmap="inferno", norm=norm, extent=_extent(found), interpolation="nearest"
    )
    _mark(axes, found)
    return mesh


def _wide(axes: Axes, found: InformationMap) -> None:
    """Show the whole band; a long thin one stretched, so that there is something to see."""
    left, right, bottom, top = _extent(found)
    axes.set(xlim=(left - WINDOW_PX, right + WINDOW_PX), ylim=(bottom + WINDOW_PX, top - WINDOW_PX))
    axes.set_aspect("auto")
    axes.set(xlabel="u, px (stretched)")


def _near(axes: Axes, found: InformationMap) -> None:
    u, v = found.moves.tip_px + 0.7 * ZOOM_PX * found.moves.axis_px
    axes.set(xlim=(u - ZOOM_PX, u + ZOOM_PX), ylim=(v + ZOOM_PX, v - ZOOM_PX), xlabel="u, px")


def _mark(axes: Axes, found: InformationMap) -> None:
    u, v = found.moves.tip_px
    axes.plot([u], [v], "o", ms=9, mfc="none", mec="#56B4E9", mew=1.4)


def _share(axes: Axes, found: InformationMap) -> None:
    rows, columns = np.indices(found.image.shape)
    u, v = columns + found.corner_px[0], rows + found.corner_px[1]
    a_u, a_v = found.moves.axis_px
    distance = (u - found.moves.tip_px[0]) * a_u + (v - found.moves.tip_px[1]) * a_v
    order = np.argsort(distance, axis=None)
    for name, layer, color in (("along", found.along, ORANGE), ("across", found.across, "#0072B2")):
        summed = np.cumsum(layer.ravel()[order]) / layer.sum()
        axes.plot(distance.ravel()[order], summed, color=color, label=name, lw=1.5)
    axes.set(xlabel="distance from the tip along the axis, px", ylabel="share of the information")
    axes.set(ylim=(-0.02, 1.05), xlim=(-10, float(distance.max())))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, loc="lower right")
