"""Reprojection errors: every corner's, and their means view by view (the paper's Fig. 5)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from simtip.calibrate.calibration import Reprojection
from simtip.calibration_images.record import Record
from simtip.report.style import GRAY, SIDES, literal, new_figure, plain

MAX_LABELS = 40


def reprojection_figure(calibration: Record) -> Figure:
    """Draw them."""
    figure = new_figure(9, 7.4)
    axes = figure.subplot_mosaic([["left", "right"], ["views", "views"]], height_ratios=[1.35, 1])
    both = np.concatenate([calibration.left.residual_px, calibration.right.residual_px])
    reach = 1.08 * max(float(np.abs(both).max()), 1e-9)
    for side, of in (("left", calibration.left), ("right", calibration.right)):
        _corners(axes[side], of, side, reach)
    _views(axes["views"], calibration)
    return figure


def _corners(axes: Axes, of: Reprojection, side: str, reach: float) -> None:
    u, v = of.residual_px.T
    axes.axhline(0, color=GRAY, lw=0.6)
    axes.axvline(0, color=GRAY, lw=0.6)
    axes.plot(u, v, ".", ms=3.5, alpha=0.45, mew=0, color=SIDES[side])
    axes.add_patch(Circle((0, 0), of.rms_px, fill=False, color="black", lw=1))
    axes.plot([], [], "o", ms=9, mfc="none", color="black", label=f"rms {of.rms_px:.3f} px")
    axes.set(xlim=(-reach, reach), ylim=(reach, -reach), aspect="equal")
    axes.set(xlabel="error in u, px", ylabel="error in v, px (down)")
    axes.set_title(f"{side} camera, {len(u)} corners, mean {of.mean_px:.3f} px", fontsize=11)
    axes.legend(frameon=False, loc="upper right")
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.yaxis.set_major_locator(MaxNLocator(6))
    plain(axes)


def _views(axes: Axes, calibration: Record) -> None:
    names = calibration.views
    at = np.arange(len(names))
    for shift, side, of in (
        (-0.2, "left", calibration.left),
        (0.2, "right", calibration.right),
    ):
        means = [_mean(of, i) for i in range(len(names))]
        axes.bar(at + shift, means, width=0.38, color=SIDES[side], label=side)
        axes.axhline(of.mean_px, color=SIDES[side], lw=1.2, ls="--")
    step = 1 + (len(names) - 1) // MAX_LABELS
    axes.set_xticks(at[::step], [_short(name) for name in names[::step]])
    if max(len(_short(name)) for name in names) > 3:
        axes.tick_params(axis="x", rotation=90)
    axes.set_xlim(-0.7, len(names) - 0.3)
    axes.set_ylim(0, 1.22 * axes.dataLim.y1)
    axes.set(xlabel="view", ylabel="mean error, px")
    axes.set_title("mean error of each view; dashed: of all corners", fontsize=11)
    axes.legend(frameon=False, loc="upper right", ncols=2)
    plain(axes)
    axes.grid(visible=False, axis="x")


def _mean(of: Reprojection, view: int) -> float:
    residual = of.of_view(view)
    return float(np.linalg.norm(residual, axis=1).mean()) if len(residual) else 0.0


def _short(name: str) -> str:
    return literal(name if len(name) <= 12 else f"..{name[-10:]}")
