"""Where in the images the corners lie, and how large their errors are there."""

from __future__ import annotations

import cv2
import numpy as np
from matplotlib.patches import Polygon, Rectangle

from simtip.calibrate import Calibration
from simtip.geometry import Array
from simtip.report.style import GRAY, new_figure, png

SHOWN_QUANTILE = 0.98
"""Errors above this quantile share the last colour."""


def plot_coverage(calibration: Calibration) -> bytes:
    """Draw both images' corners as a PNG file."""
    left = calibration.rig.left
    figure = new_figure(12.4, 0.9 + 5.6 * left.height / left.width)
    axes = figure.subplots(1, 2)
    lengths = [
        np.linalg.norm(of.residual_px, axis=1) for of in (calibration.left, calibration.right)
    ]
    most = float(np.quantile(np.concatenate(lengths), SHOWN_QUANTILE))
    dots = None
    for ax, side, of, length in zip(
        axes, ("left", "right"), (calibration.left, calibration.right), lengths, strict=True
    ):
        camera = calibration.rig.left if side == "left" else calibration.rig.right
        pixels = of.corners.pixels
        ax.add_patch(
            Rectangle((-0.5, -0.5), camera.width, camera.height, fc="#f4f4f4", ec=GRAY, lw=1)
        )
        hull = _hull(pixels)
        ax.add_patch(Polygon(hull, fill=False, ec=GRAY, lw=1, ls="--"))
        order = np.argsort(length)
        dots = ax.scatter(
            *pixels[order].T,
            c=length[order],
            s=7,
            lw=0,
            cmap="viridis",
            vmin=0,
            vmax=max(most, 1e-12),
        )
        share = _area(hull) / (camera.width * camera.height)
        ax.set_title(f"{side}: {len(pixels)} corners, within {share:.0%} of the image", fontsize=11)
        margin = 0.02 * camera.width
        ax.set(
            xlim=(-margin, camera.width + margin),
            ylim=(camera.height + margin, -margin),
            aspect="equal",
            xlabel="u, px",
            ylabel="v, px",
        )
        ax.spines[:].set_visible(False)
    if dots is not None:
        figure.colorbar(
            dots, ax=list(axes), label="reprojection error, px", shrink=0.85, extend="max"
        )
    return png(figure)


def _hull(pixels: Array) -> Array:
    return np.asarray(cv2.convexHull(pixels.astype(np.float32)), dtype=np.float64).reshape(-1, 2)


def _area(outline: Array) -> float:
    return float(cv2.contourArea(outline.astype(np.float32)))
