"""Distances of corners from their epipolar lines (the paper's Fig. 10), under three F."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from simtip.calibration_images.record import Record
from simtip.geometry import Array
from simtip.report.style import BLUE, GRAY, ORANGE, new_figure, plain

BINS = 30


def epipolar_figure(calibration: Record) -> Figure:
    """Draw each corner's distance and their distributions."""
    figure = new_figure(10, 7.4)
    axes = figure.subplot_mosaic([["each", "each"], ["raw", "undistorted"]], height_ratios=[1, 1.1])
    _each(axes["each"], calibration.rig_px)
    _distribution(
        axes["raw"],
        "images as they are, as in the paper",
        [("eight-point F", calibration.raw_px, GRAY)],
    )
    _distribution(
        axes["undistorted"],
        "undistorted",
        [
            ("eight-point F", calibration.eight_point_px, BLUE),
            ("F of the rig", calibration.rig_px, ORANGE),
        ],
    )
    return figure


def _distribution(axes: Axes, title: str, kinds: Sequence[tuple[str, Array, str]]) -> None:
    most = max(float(distances.max()) for _, distances, _ in kinds)
    edges = np.linspace(0, max(most, 1e-12), BINS + 1)
    for name, distances, color in kinds:
        label = f"{name}: mean {distances.mean():.3f}, max {distances.max():.3f} px"
        axes.hist(distances, edges.tolist(), histtype="stepfilled", color=color, alpha=0.12)
        axes.hist(distances, edges.tolist(), histtype="step", color=color, lw=1.5, label=label)
        axes.axvline(distances.mean(), color=color, lw=1.2, ls="--")
    axes.set(xlabel="distance from the epipolar line, px", ylabel="corners", xlim=(0, edges[-1]))
    axes.set_ylim(0, 1.3 * axes.dataLim.y1)
    axes.set_title(f"{title}; dashed: mean", fontsize=11)
    axes.legend(frameon=False, loc="upper right")
    plain(axes)


def _each(axes: Axes, distances: Array) -> None:
    mean, most = float(distances.mean()), float(distances.max())
    axes.plot(distances, ".", ms=3, mew=0, color=ORANGE, alpha=0.7)
    axes.axhline(mean, color="black", lw=1.2, label=f"mean {mean:.3f} px")
    axes.axhline(most, color="black", lw=1.2, ls=":", label=f"max {most:.3f} px")
    axes.set(xlabel="corner, view after view", ylabel="distance, px")
    axes.set(xlim=(0, len(distances)), ylim=(0, 1.25 * max(most, 1e-12)))
    axes.set_title(
        "right corners from the lines of the left ones; F of the rig, undistorted", fontsize=11
    )
    axes.legend(frameon=False, loc="upper right", ncols=2)
    plain(axes)
