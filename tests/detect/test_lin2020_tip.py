"""Does the whole extraction give the known pixel of a drawn needle, or the right reason?"""

import re

import cv2
import numpy as np
import pytest

from simtip.detect import TipStatus, lin2020
from simtip.detect.lin2020_parameters import Lin2020Parameters

BAR = (slice(0, 300), slice(100, 121))  # 300 x 21 px, enters at the top; last row 299, middle 110


def scene(dark=40, background=180, shape=(400, 300)):
    image = np.full(shape, background, np.uint8)
    image[BAR] = dark
    return image


def found(image, **values):
    observation = lin2020.detect(image, Lin2020Parameters(**values))
    assert observation.ok, observation.reason
    return observation


def reason(image, **values):
    observation = lin2020.detect(image, Lin2020Parameters(**values))
    assert not observation.ok
    assert observation.tip_px is None
    assert observation.axis_px is None
    return observation.status, observation.reason


def stage(image, name, **values):
    return lin2020.detect(image, Lin2020Parameters(**values), layers=True).layers[name]


def test_a_bar_is_found_at_its_end_with_its_axis_up():
    # the median of 5 rounds the bar's corners off by one pixel and leaves its last row
    observation = found(scene())
    assert observation.tip_px.tolist() == [110, 299]
    assert observation.axis_px == pytest.approx([0, -1], abs=1e-9)
    assert observation.covariance_px is None


def test_a_bar_of_even_width_is_found_between_two_pixels():
    image = scene()
    image[0:300, 121] = 40
    assert found(image).tip_px.tolist() == [110.5, 299]


@pytest.mark.parametrize("tip", [(110, 350), (110.25, 350.5), (111.9, 349.2), (110.5, 350.75)])
def test_a_slender_cone_is_found_on_its_last_dark_row(tip):
    image = np.full((400, 300), 255, np.uint8)
    u, v = tip
    corners = np.array([(u, v), (u - 14, v - 56), (u - 10, -9), (u + 10, -9), (u + 6, v - 56)])
    shift = 6
    cv2.fillConvexPoly(image, np.round(corners * 2**shift).astype(np.int32), 0, shift=shift)
    rows, columns = np.nonzero(image == 0)
    end = columns[rows == rows.max()]
    observation = found(image, median_window=1)
    assert observation.tip_px[1] == rows.max()
    assert end.min() - 1 <= observation.tip_px[0] <= end.max()


def test_the_threshold_itself_is_background():
    assert reason(scene(dark=105))[0] == TipStatus.NOTHING_DARKER_THAN_THRESHOLD
    assert found(scene(dark=104)).tip_px.tolist() == [110, 299]


def test_every_parameter_reaches_its_step():
    """A value that changes the outcome of one step changes the outcome of the whole."""
    assert reason(scene(), threshold=40)[0] == TipStatus.NOTHING_DARKER_THAN_THRESHOLD
    assert reason(scene(), min_area_px=300 * 21 + 1)[0] == TipStatus.NO_COMPONENT_LARGE_ENOUGH
    assert reason(scene(), canny_low=5000, canny_high=5000)[0] == TipStatus.NO_EDGE
    assert found(scene(), ties="left").tip_px[0] < 110 < found(scene(), ties="right").tip_px[0]
    assert found(scene(), median_window=1, ties="left").tip_px[0] == 100
    assert reason(scene(), border_margin_px=101)[0] == TipStatus.TOUCHES_BORDER
    assert found(scene(), border_margin_px=100).ok

    red = np.stack([np.full_like(scene(), 200), scene(), scene()], axis=-1)
    assert reason(red, weights=(1, 0, 0))[0] == TipStatus.NOTHING_DARKER_THAN_THRESHOLD
    assert found(red, weights=(0, 1, 0)).ok

    twelve_bit = scene().astype(np.uint16) * 16
    assert found(twelve_bit, full_scale=4095).tip_px.tolist() == [110, 299]
    assert reason(twelve_bit)[0] == TipStatus.EVERYTHING_DARKER_THAN_THRESHOLD

    chain = scene()
    for i in range(20):  # joined to the bar by corners alone
        chain[300 + i, 121 + i] = 40
    values = {"median_window": 1, "min_area_px": 21}
    assert found(chain, **values, connectivity=8).tip_px[1] == 319
    assert found(chain, **values, connectivity=4).tip_px[1] == 299

    holed = scene()
    holed[100:120, 105:115] = 180
    values = {"min_area_px": 500}
    assert stage(holed, "cleaned", **values)[110, 110] == 255
    assert stage(holed, "cleaned", **values, polarity="both")[110, 110] == 0

    slanted = np.full((400, 300), 180, np.uint8)
    cv2.fillPoly(slanted, [np.array([(100, -9), (150, -9), (210, 300), (190, 310)])], 40)
    plain = stage(slanted, "edges")
    low_high = {"canny_low": 1050, "canny_high": 1200}
    for values in ({"canny_aperture": 7}, low_high, {**low_high, "canny_l2": True}):
        assert not np.array_equal(stage(slanted, "edges", **values), plain)
    assert not np.array_equal(
        stage(slanted, "edges", **low_high), stage(slanted, "edges", **low_high, canny_l2=True)
    )


def test_a_lower_object_is_the_tip_unless_only_the_largest_is_kept():
    image = scene()
    image[320:380, 150:250] = 40  # 6000 px, less than the bar's 6300
    assert found(image, keep="all").tip_px[1] == 379
    assert found(image, keep="largest").tip_px.tolist() == [110, 299]


def test_dust_below_the_needle_is_no_tip():
    image = scene()
    image[340:350, 150:160] = 40
    assert found(image).tip_px.tolist() == [110, 299]


def test_reasons_carry_the_numbers():
    status, text = reason(np.full((50, 50), 131, np.uint8))
    assert status == "nothing_darker_than_threshold"
    assert text == "no pixel is darker than T = 105 (darkest is 131)"

    status, text = reason(np.full((50, 50), 90, np.uint8))
    assert status == "everything_darker_than_threshold"
    assert text == "every pixel is darker than T = 105 (brightest is 90)"

    image = np.full((200, 200), 200, np.uint8)
    image[50:90, 50:80] = image[120:140, 50:80] = 0
    status, text = reason(image, median_window=1)
    assert status == "no_component_large_enough"
    assert "4500 px" in text
    assert "largest of 2 has 1200 px" in text

    status, text = reason(scene(), canny_low=3000, canny_high=4000)
    assert status == "no_edge"
    assert "3000 / 4000" in text


@pytest.mark.parametrize(
    "needle",
    [
        (slice(150, 300), slice(100, 150)),  # leaves at the bottom
        (slice(100, 150), slice(150, 300)),  # at the right
        (slice(100, 150), slice(0, 150)),  # at the left
        (slice(0, 2), slice(20, 280)),  # only the top rows are dark
    ],
)
def test_a_lower_end_at_any_border_is_no_tip(needle):
    image = np.full((300, 300), 180, np.uint8)
    image[needle] = 40
    status, text = reason(image, min_area_px=500)
    assert status == "touches_border"
    assert re.search(r"is [01] px from the border of the 300 x 300 image", text)


@pytest.mark.parametrize(("gap", "ok"), [(2, False), (3, True)])
def test_the_margin_counts_pixels_between_tip_and_border(gap, ok):
    image = np.full((300, 300), 180, np.uint8)
    image[: 300 - gap, 100:130] = 40
    observation = lin2020.detect(image, Lin2020Parameters(median_window=1))
    assert observation.ok is ok
    if ok:
        assert observation.tip_px[1] == 296


def test_layers_are_kept_on_request_only():
    assert found(scene()).layers == {}
    layers = lin2020.detect(scene(), layers=True).layers
    assert list(layers) == ["gray", "filtered", "binary", "cleaned", "edges"]
    assert all(layer.shape == (400, 300) and layer.dtype == np.uint8 for layer in layers.values())
    failed = lin2020.detect(np.zeros((9, 9), np.uint8), layers=True)
    assert list(failed.layers) == list(layers)
