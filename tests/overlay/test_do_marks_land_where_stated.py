"""Marks are weighed on a gray image, where only they have colour.

A mark's share of a pixel is in proportion to the colour it brings (blue - red for the true tip),
so its centre of mass is measured without knowing how it was drawn. The inset is found, and its
scale measured, by a pure green pixel near the tip that it must show as a square.
"""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from simtip.overlay import draw_view
from simtip.overlay.inset import Inset

WIDTH, HEIGHT = 1000, 700
REFERENCE = (412, 309)
TIPS = [(400.0, 300.0), (400.5, 300.5), (399.63, 301.21), (400.25, 299.9)]
MARKS = {"tip_true_px": 1.0, "tip_detected_px": -1.0}
NEAR_PX = 0.1


def gray_image():
    image = np.full((HEIGHT, WIDTH, 3), 150, np.uint8)
    image[REFERENCE[1], REFERENCE[0]] = (0, 255, 0)
    return image


def blue_minus_red(view):
    return view[..., 2].astype(float) - view[..., 0]


def centre_of_mass(weight, around, reach):
    """Weigh a square window, clear of whatever else is drawn."""
    u0, v0 = round(around[0]) - reach, round(around[1]) - reach
    part = np.clip(weight, 0, None)[v0 : v0 + 2 * reach + 1, u0 : u0 + 2 * reach + 1]
    assert part.sum() > 500, "no mark here"
    v, u = np.indices(part.shape)
    return np.array([u0 + (part * u).sum() / part.sum(), v0 + (part * v).sum() / part.sum()])


def green_square(view):
    """Centre and side of the enlarged reference pixel."""
    green = np.all(view == (0, 255, 0), axis=2).astype(np.uint8)
    _, _, stats, centres = cv2.connectedComponentsWithStats(green)
    largest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    side = stats[largest, cv2.CC_STAT_WIDTH]
    assert side >= 3
    assert stats[largest, cv2.CC_STAT_HEIGHT] == side
    assert stats[largest, cv2.CC_STAT_AREA] == side**2
    return centres[largest], int(side)


def inset_error(view, tip, sign):
    """Where the mark in the inset lies, from where the enlarged pixels say it should, px."""
    square, k = green_square(view)
    expected = square + k * (np.array(tip) - REFERENCE)
    return centre_of_mass(sign * blue_minus_red(view), expected, 8 * k) - expected


@pytest.mark.parametrize("name", MARKS)
@pytest.mark.parametrize("tip", TIPS)
def test_in_the_image(name, tip):
    view = draw_view(gray_image(), title="view", **{name: tip})
    found = centre_of_mass(MARKS[name] * blue_minus_red(view), tip, 40)
    np.testing.assert_allclose(found, tip, atol=NEAR_PX)


@pytest.mark.parametrize("name", MARKS)
@pytest.mark.parametrize("tip", TIPS)
def test_in_the_inset(name, tip):
    view = draw_view(gray_image(), title="view", **{name: tip})
    np.testing.assert_allclose(inset_error(view, tip, MARKS[name]), 0, atol=NEAR_PX)


def test_in_the_inset_of_a_tip_near_the_corner():
    image = gray_image()
    image[4, 9] = (0, 255, 0)
    image[REFERENCE[1], REFERENCE[0]] = 150
    view = draw_view(image, title="view", tip_detected_px=(20.3, 18.8))
    square, k = green_square(view)
    expected = square + k * np.array([20.3 - 9, 18.8 - 4])
    found = centre_of_mass(-blue_minus_red(view), expected, 4 * k)
    np.testing.assert_allclose(found, expected, atol=NEAR_PX)


@pytest.mark.parametrize(
    "faulty",
    [
        lambda k, d: (d + 0.5) * k,
        lambda k, d: d * k,
        lambda k, d: d * k - 0.5,
    ],
)
def test_a_half_pixel_fault_in_the_inset_is_seen(monkeypatch, faulty):
    def point(self, p):
        return faulty(self.factor, p - np.array([self.source.u0, self.source.v0]))

    monkeypatch.setattr(Inset, "point", point)
    view = draw_view(gray_image(), title="view", tip_true_px=TIPS[0])
    assert np.abs(inset_error(view, TIPS[0], 1.0)).min() > 4 * NEAR_PX


def line_through(point, angle):
    a, b = -np.sin(angle), np.cos(angle)
    return 3.0 * np.array([a, b, -(a * point[0] + b * point[1])])


def heights(view, columns, rows):
    """Centre of mass along v of the line's colour (red - green), column by column.

    Pixels are squares, so that of a band w px wide may be off by up to 1 / (8 w) px.
    """
    weight = np.clip(view[..., 0].astype(float) - view[..., 1], 0, None)[rows][:, columns]
    v = np.arange(view.shape[0])[rows]
    return (weight * v[:, None]).sum(axis=0) / weight.sum(axis=0)


@pytest.mark.parametrize("angle", [0.0, 0.3, -0.7])
def test_the_epipolar_line_in_the_image(angle):
    point = (450.3, 360.2)
    view = draw_view(gray_image(), title="", epipolar_line=line_through(point, angle))
    columns = np.arange(400, 600)
    found = heights(view, columns, np.arange(200, 600))
    expected = point[1] + (columns - point[0]) * np.tan(angle)
    assert np.abs(found - expected).max() < 0.15
    assert abs((found - expected).mean()) < 0.05


@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_the_epipolar_line_in_the_inset(angle):
    point = (400.3, 312.4)
    view = draw_view(
        gray_image(), title="", tip_true_px=(400, 300), epipolar_line=line_through(point, angle)
    )
    square, k = green_square(view)
    columns = round(square[0]) + np.arange(k + 1, 4 * k)
    expected = square[1] + k * (point[1] - REFERENCE[1])
    expected = expected + (columns - square[0] - k * (point[0] - REFERENCE[0])) * np.tan(angle)
    rows = np.arange(round(expected.min()) - 2 * k, round(expected.max()) + 2 * k)
    rows = rows[rows > square[1] + k / 2]
    found = heights(view, columns, rows)
    assert np.abs(found - expected).max() < 0.15
    assert abs((found - expected).mean()) < 0.1


def test_the_inset_shows_each_pixel_as_a_square():
    rng = np.random.default_rng(3)
    image = gray_image()
    image[rng.random((HEIGHT, WIDTH)) < 0.3] = 140
    image[REFERENCE[1], REFERENCE[0]] = (0, 255, 0)
    view = draw_view(image, title="", tip_true_px=(400, 300))
    square, k = green_square(view)
    du, dv = np.meshgrid(np.arange(-4, 5), np.arange(-4, 5))
    shown = [
        view[
            round(square[1] - (k - 1) / 2) + k * y : round(square[1] + (k + 1) / 2) + k * y,
            round(square[0] - (k - 1) / 2) + k * x : round(square[0] + (k + 1) / 2) + k * x,
        ]
        for x, y in zip(du.ravel(), dv.ravel(), strict=True)
    ]
    for block, x, y in zip(shown, du.ravel(), dv.ravel(), strict=True):
        assert block.shape == (k, k, 3)
        assert (block == image[REFERENCE[1] + y, REFERENCE[0] + x]).all()


def test_both_tips_are_in_the_inset_up_to_some_distance():
    true, detected = (400.0, 300.0), (385.4, 280.7)
    view = draw_view(
        gray_image(), title="", tip_true_px=true, tip_detected_px=detected, axis_px=(0, -1)
    )
    for tip, sign in ((true, 1.0), (detected, -1.0)):
        square, k = green_square(view)
        expected = square + k * (np.array(tip) - REFERENCE)
        found = centre_of_mass(sign * blue_minus_red(view), expected, 6 * k)
        np.testing.assert_allclose(found, expected, atol=NEAR_PX)


def test_the_inset_follows_the_tip_that_is_inside():
    tip = (400.3, 300.1)
    view = draw_view(gray_image(), title="", tip_true_px=(-30, 5), tip_detected_px=tip)
    np.testing.assert_allclose(inset_error(view, tip, -1.0), 0, atol=NEAR_PX)


@pytest.mark.parametrize("tip", [(0, 0), (WIDTH - 1, 0), (0, HEIGHT - 1), (WIDTH - 1, HEIGHT - 1)])
def test_the_inset_reaches_the_corners_of_the_image(tip):
    image = gray_image()
    inwards = 1 - 2 * (np.array(tip) > 0)
    reference = tip + inwards * (9, 12)
    image[REFERENCE[1], REFERENCE[0]] = 150
    image[reference[1], reference[0]] = (0, 255, 0)
    view = draw_view(image, title="", tip_detected_px=tip)
    square, k = green_square(view)
    expected = square + k * (np.array(tip) - reference)
    found = centre_of_mass(-blue_minus_red(view), expected, k // 2)
    np.testing.assert_allclose(found, expected, atol=NEAR_PX)
