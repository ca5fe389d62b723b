"""Is the brightness within a needle blurred as the needle is, and not only averaged nearby?"""

import cv2
import numpy as np
import pytest

from simtip.detect.subpixel.brightness import (
    BLURRED_ROWS,
    SHAFT_COLUMNS,
    SHAFT_EVEN,
    SHAFT_ODD,
    blurred_columns,
    shaft_columns,
)
from simtip.detect.subpixel.edge_table import brightness_integral
from simtip.detect.subpixel.picture import Cells, Placed, Window, cover

WINDOW = Window(0, 0, 40, 60)
FINE = 16
HALF_PX = 9.0
CORNERS = np.array([[11.2, -40], [11.2, 15], [20.2, 52], [29.2, 15], [29.2, -40]])
NEEDLE = Placed(
    CORNERS, np.zeros((0, 2)), np.array([20.2, 52.0]), np.array([0.0, -1.0]), HALF_PX, 37.0
)
MODES = np.random.default_rng(2).normal(0, 0.15, SHAFT_COLUMNS - 2)
WITHIN = np.array([0.5, *MODES, 0.0])
"""Brightness: half of what lies behind, and uneven; it does not change along the needle."""


def drawn(sigma_px, disc_px):
    """Give the blurred picture and the blurred cover (H, W), every fine cell drawn."""
    pad = 8
    v, u = ((np.arange((n + 2 * pad) * FINE) + 0.5) / FINE - 0.5 - pad for n in (60, 40))
    left = np.interp(v, CORNERS[:3, 1], CORNERS[:3, 0])[:, None]
    inside = ((u > left) & (u < 2 * 20.2 - left) & (v < 52)[:, None]).astype(np.float32)
    edges = (np.append(u - 0.5 / FINE, u[-1] + 0.5 / FINE) - 20.2) / HALF_PX
    integral = np.diff(brightness_integral(edges, SHAFT_EVEN, SHAFT_ODD), axis=0)
    wide = np.diff(np.clip(edges, -1, 1))
    level = np.where(wide > 0, integral @ WITHIN[:-1] / np.maximum(wide, 1e-9), 0)
    fine = np.stack([inside * level.astype(np.float32), inside], axis=2)
    if disc_px:
        reach = int(disc_px * FINE) + 1
        y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
        disc = (np.hypot(x, y) < disc_px * FINE).astype(np.float32)
        fine = cv2.filter2D(fine, -1, disc / disc.sum())
    if sigma_px:
        fine = cv2.GaussianBlur(fine, (0, 0), sigma_px * FINE)
    pixels = fine.reshape(60 + 2 * pad, FINE, 40 + 2 * pad, FINE, 2).mean(axis=(1, 3))
    return np.moveaxis(pixels[pad:-pad, pad:-pad], 2, 0)


@pytest.mark.parametrize(("sigma_px", "disc_px"), [(0.7, 0.0), (1.3, 0.0), (0.6, 2.2), (0.4, 3.0)])
def test_as_one_that_is_drawn_and_blurred(sigma_px, disc_px):
    picture, _ = drawn(sigma_px, disc_px)
    disc_px2 = disc_px**2 / 4
    variance = sigma_px**2 + disc_px2
    share = disc_px2 / variance
    covered = cover(NEEDLE, Cells(WINDOW, variance, share)).whole
    columns = blurred_columns(NEEDLE, Cells(WINDOW, variance, share, BLURRED_ROWS))
    ours = covered * (columns[:, :SHAFT_COLUMNS] @ WITHIN)
    assert np.abs(ours - picture.reshape(-1)).max() < 0.006
    # An average over as far as the blur reaches is off several times as much.
    v, u = (each.reshape(-1).astype(float) for each in np.mgrid[:60, :40])
    near = shaft_columns(NEEDLE, u, v, NEEDLE.sides_of(v), 0.5 + variance**0.5)
    averaged = covered * (near @ WITHIN)
    off = np.abs(averaged - picture.reshape(-1)).max()
    assert off > 3 * np.abs(ours - picture.reshape(-1)).max()
