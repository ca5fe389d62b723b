"""One picture against a known needle: how well a place of it explains the pixels at the tip."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.polynomial import polyval

from simtip.detect.protocol import Image
from simtip.detect.subpixel.analysis import Analysis
from simtip.detect.subpixel.gray import mean_gray
from simtip.detect.subpixel.picture import Window
from simtip.detect.subpixel.shaft_noise import LEAST_NOISE_DN2
from simtip.geometry import Array, Pose
from simtip.refine.cells import Cells
from simtip.refine.drawing import Drawing
from simtip.refine.outline import Eye, outline
from simtip.refine.shading import Layout, columns, layout_of, picture, prior, window_points
from simtip.refine.solid import Solid

SIDE_PX, BELOW_PX = 8.0, 10.0
SHAFT_WIDTHS, SHAFT_MOST_PX = 7.0, 240.0
"""Of shaft beyond the tip that are compared: so many widths, or px if that is less."""

MARGIN_MM = 20.0
"""The needle is drawn so far beyond the window."""

RIPPLE_SHARE = 0.012
"""Of the background's gray value, what ripples of lossy storage leave: 0.011 of JPEG at quality 40.
"""


@dataclass(frozen=True, eq=False)
class Fit:
    """An outline's best brightness, and what is left.

    Attributes
    ----------
    columns, amplitude
        (H W, n), (n,) what the picture is made of, and how much of each.
    weight, residual
        (H W,) one over the noise's variance, or 0; gray values less the picture.
    normal
        (n, n) normal matrix of the amplitudes.
    layout
        What the columns are.
    cost
        -2 log likelihood, but for a constant.
    misfit
        Mean squared residual over the noise.
    """

    columns: Array
    amplitude: Array
    weight: Array
    residual: Array
    normal: Array
    layout: Layout
    cost: float
    misfit: float


@dataclass(frozen=True, eq=False)
class View:
    """What is compared in one picture.

    Attributes
    ----------
    eye
        The camera.
    window, value
        Pixels, and (H W,) their gray values.
    used
        (H W,) 1 where a pixel counts, 0 where it is too far from the needle.
    noise
        (3,) variance of a gray value, DN^2, as a polynomial of it, constant first.
    level
        The background's gray value.
    end
        Row in which the needle ends.
    end_mm
        z of the needle at which it is out of the window.
    blur_px
        Deviation of the blur, to begin with.
    eight_bit
        Whether the picture may have been stored with loss.
    ripples
        How many times the noise that the picture's flat parts show is taken for it.
    """

    eye: Eye
    window: Window
    value: Array
    used: Array
    noise: Array
    level: float
    end: int
    end_mm: float
    blur_px: float
    eight_bit: bool
    ripples: float = 1.0

    @classmethod
    def of(
        cls, image: Image, analysis: Analysis, eye: Eye, solid: Solid, T_wn: Pose, full: int | None
    ) -> View:
        """Choose the pixels around a needle that is about in its place."""
        turned = analysis.frame.view(mean_gray(image, full))
        T_cn = eye.T_cw @ T_wn
        depth, step = solid.depth_mm, 2 * solid.radius_mm
        at = np.array([[0, 0, 0], [0, 0, depth], [0, 0, depth + step]], np.float64)
        ends = eye.see(T_cn.apply(at))
        width = float(np.linalg.norm(ends[2] - ends[1]))
        shaft_mm = min(SHAFT_WIDTHS, SHAFT_MOST_PX / max(width, 1e-3)) * step
        shaft_mm = min(shaft_mm, solid.length_mm - depth)
        corners = eye.see(T_cn.apply(at + np.array([0, 0, shaft_mm])))
        box = np.concatenate([ends[:1], corners[1:2]])
        half = width / 2 + SIDE_PX + 3 * float(np.sqrt(analysis.scenery.variance_px2))
        low = np.floor([box[:, 0].min() - half, box[:, 1].min()]).astype(int)
        high = np.ceil([box[:, 0].max() + half, box[:, 1].max() + BELOW_PX]).astype(int)
        low = np.maximum(low, 0)
        high = np.minimum(high, [turned.shape[1] - 1, turned.shape[0] - 1])
        window = Window(int(low[0]), int(low[1]), *(int(n) + 1 for n in high - low))
        part = turned[low[1] : high[1] + 1, low[0] : high[0] + 1].astype(np.float64)
        end_mm = depth + shaft_mm + MARGIN_MM
        drawn = outline(solid, T_wn, eye, end_mm)
        x, z = drawn.place(*window_points(window))
        left, right = drawn.sides(np.maximum(z, drawn.depth_px))
        used = ((x > left - half + width / 2) & (x < right + half - width / 2)).astype(np.float64)
        return cls(
            eye,
            window,
            part.reshape(-1),
            used.reshape(-1),
            analysis.shaft.noise,
            analysis.trace.level,
            int(np.rint(drawn.corners[:, 1].max())),
            end_mm,
            float(np.sqrt(analysis.scenery.variance_px2)),
            image.dtype == np.uint8,
        )

    def with_noise_left(self, fit: Fit) -> View:
        """Give it with less noise, if a fit leaves less than was thought.

        Lossy storage smooths what is flat, from which the noise is told, and leaves ripples about
        edges. So where the noise of an 8-bit picture, taken to gray value 0, is no more than what
        rounding makes, what a fit leaves is taken for it, up to a small part of the background's
        gray value.
        """
        share = fit.misfit
        if self.noise[0] > LEAST_NOISE_DN2 or not self.eight_bit:
            return replace(self, noise=self.noise * min(1.0, share))
        told = float(polyval(self.level, self.noise))
        share = min(share, max(1.0, (RIPPLE_SHARE * self.level) ** 2 / told))
        return replace(self, noise=self.noise * share, ripples=max(1.0, share))

    def draw(self, solid: Solid, T_wn: Pose, blur_px: float) -> Drawing:
        """Draw the needle where it is supposed to be."""
        drawn = outline(solid, T_wn, self.eye, self.end_mm)
        return Drawing.of(drawn, Cells.over(self.window, blur_px, self.end), curved=solid.curved)

    def fit(self, solid: Solid, T_wn: Pose, blur_px: float) -> Fit:
        """Find the brightness that explains the pixels best, the needle in a given place."""
        drawing = self.draw(solid, T_wn, blur_px)
        layout = layout_of(drawing, curved=solid.curved)
        made = columns(drawing, self.window, layout)
        noise = polyval(np.maximum(self.value, 0), self.noise)
        weight: Array = (self.used / noise).astype(np.float64)
        precision, mean = prior(layout, self.level)
        weighted = made * weight[:, None]
        normal = weighted.T @ made + np.diag(precision)
        right = weighted.T @ self.value + precision * mean
        amplitude: Array = np.linalg.solve(normal, right).astype(np.float64)
        residual = self.value - made @ amplitude
        chi2 = float((residual**2 * weight).sum())
        misfit = chi2 / max(float(self.used.sum()), 1.0)
        cost = chi2 + float((precision * (amplitude - mean) ** 2).sum())
        return Fit(made, amplitude, weight, residual, normal, layout, cost, misfit)

    def change(
        self, found: Fit, solid: Solid, places: list[tuple[Pose, float]], steps: Array, base: Array
    ) -> Array:
        """Give derivatives (H W, n) of the picture at fixed brightness, from n moved places."""
        moved = [
            picture(self.draw(solid, *place), self.window, found.layout, found.amplitude)
            for place in places
        ]
        return np.stack([(one - base) / step for one, step in zip(moved, steps, strict=True)], 1)
