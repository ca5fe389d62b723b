"""Where in the images the corners lie, and how large their errors are there."""

from __future__ import annotations

import cv2
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from simtip.calibration_images.record import Record
from simtip.geometry import Array
from simtip.report.style import GRAY, new_figure

SHOWN_QUANTILE = 0.98
"""Errors above this quantile share the last colour."""


def coverage_figure(calibration: Record) -> Figure:
    """Draw both images' corners."""
    width, height = calibration.sizes[0]
    figure = new_figure(12.4, 0.9 + 5.6 * height / width)
    axes = figure.subplots(1, 2)
    lengths = [
        np.linalg.norm(of.residual_px, axis=1) for of in (calibration.left, calibration.right)
    ]
    most = float(np.quantile(np.concatenate(lengths), SHOWN_QUANTILE))
    dots = None
    for ax, side, of, length, (width, height) in zip(
        axes,
        ("left", "right"),
        (calibration.left, calibration.right),
        lengths,
        calibration.sizes,
        strict=True,
    ):
        pixels = of.corners.pixels
        ax.add_patch(Rectangle((-0.5, -0.5), width, height, fc="#f4f4f4", ec=GRAY, lw=1))
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
        share = _area(hull) / (width * height)
        ax.set_title(f"{side}: {len(pixels)} corners, within {share:.0%} of the image", fontsize=11)
        margin = 0.02 * width
        ax.set(
            xlim=(-margin, width + margin),
            ylim=(height + margin, -margin),
            aspect="equal",
            xlabel="u, px",
            ylabel="v, px",
        )
        ax.spines[:].set_visible(False)
    if dots is not None:
        figure.colorbar(
            dots, ax=list(axes), label="reprojection error, px", shrink=0.85, extend="max"
        )
    return figure


def _hull(pixels: Array) -> Array:
    return np.asarray(cv2.convexHull(pixels.astype(np.float32)), dtype=np.float64).reshape(-1, 2)


def _area(outline: Array) -> float:
    return float(cv2.contourArea(outline.astype(np.float32)))
