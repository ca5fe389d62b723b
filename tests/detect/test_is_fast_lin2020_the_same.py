"""Does `lin2020` give, bit by bit, what its steps give one after the other on the whole image?"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hard_images import KINDS, case
from oracles import lin2020_oracle

from simtip.detect import TipStatus, lin2020, lin2020_steps
from simtip.detect.binarised import SLACK_DN, _average, binarised
from simtip.detect.contract.probe import FAULTS
from simtip.detect.gray import LUMA_WEIGHTS, to_gray
from simtip.detect.lin2020_parameters import Lin2020Parameters

IMAGES = 500
PARTS = 10
"""The first two are run by the quick tests."""


OF_USERS = FAULTS | {TipStatus.NOT_FOUND}
"""Statuses that only users' detectors give."""


def same(a, b):
    return (a is None and b is None) or (
        a is not None and b is not None and a.tobytes() == b.tobytes()
    )


def differences(number, *, layers):
    """Name what is not the same about one image."""
    kind, image, p = case(number)
    before = image.copy()
    expected = lin2020_oracle.detect(image, p, layers=layers)
    seen = lin2020.detect(image, p, layers=layers)
    checks = {
        "status": seen.status == expected.status,
        "reason": seen.reason == expected.reason,
        "tip": same(seen.tip_px, expected.tip_px),
        "axis": same(seen.axis_px, expected.axis_px),
        "names of layers": list(seen.layers) == list(expected.layers),
        "image": np.array_equal(image, before),
        **{name: same(seen.layers[name], expected.layers[name]) for name in seen.layers},
    }
    return [f"{number} ({kind}, {p}): {name}" for name, ok in checks.items() if not ok]


@pytest.mark.parametrize(
    "part", [pytest.param(k, marks=[pytest.mark.slow] * (k > 1)) for k in range(PARTS)]
)
def test_on_five_hundred_images_everything_is_the_same(part):
    numbers = range(part * IMAGES // PARTS, (part + 1) * IMAGES // PARTS)
    assert [d for k in numbers for d in differences(k, layers=k % 3 == 0)] == []


def test_the_images_are_of_all_kinds_and_come_to_every_end():
    cases = [case(k) for k in range(100)]
    assert {kind for kind, _, _ in cases} == {kind.__name__ for kind in KINDS}
    ends = Counter(lin2020_oracle.detect(image, p).status for _, image, p in cases)
    assert set(ends) == set(TipStatus) - OF_USERS
    assert ends[TipStatus.OK] > 25
    forms = {(image.dtype.itemsize, image.ndim) for _, image, _ in cases}
    assert forms == {(1, 2), (1, 3), (2, 2), (2, 3)}


@pytest.mark.parametrize("connectivity", [4, 8])
def test_of_equal_components_the_same_one_is_the_first(connectivity):
    p = Lin2020Parameters(median_window=1, min_area_px=0, keep="largest", connectivity=connectivity)
    for v, u in np.ndindex(8, 8):
        image = np.full((40, 60), 200, np.uint8)
        image[v + 11 : v + 20, u + 10 : u + 14] = image[v + 10 : v + 19, u + 20 : u + 24] = 0
        expected, seen = lin2020_oracle.detect(image, p), lin2020.detect(image, p)
        assert seen.tip_px.tolist() == expected.tip_px.tolist()


def test_canny_sees_all_of_its_window():
    image = np.full((60, 60), 200, np.uint8)
    image[12:30, 20:40] = 0
    for aperture in (3, 5, 7):
        p = Lin2020Parameters(
            median_window=1, min_area_px=0, canny_aperture=aperture, canny_low=0, canny_high=1
        )
        expected, seen = lin2020_oracle.detect(image, p), lin2020.detect(image, p)
        assert seen.tip_px.tolist() == expected.tip_px.tolist()


@pytest.mark.parametrize("threshold", [1, 2, 105, 128, 254, 255])
@pytest.mark.parametrize("full_scale", [None, 1, 200, 1023, 4095])
def test_every_gray_value_is_on_the_right_side_of_the_threshold(threshold, full_scale):
    white = full_scale or 65535
    values = np.arange(white + 1, dtype=np.uint16)[None]
    expected = lin2020_steps.binarise(to_gray(values, full_scale=full_scale), threshold)
    assert np.array_equal(binarised(values, threshold, full_scale=full_scale), expected)
    bytes_ = np.arange(256, dtype=np.uint8)[None]
    assert np.array_equal(binarised(bytes_, threshold), lin2020_steps.binarise(bytes_, threshold))


def around(threshold, weights, white, dtype, rng):
    """Colours, most of them within two gray levels of the threshold."""
    brightest = min(white, 2 * threshold * white // 255)
    colours = rng.integers(0, brightest + 1, (60_000, 3))
    rest = (threshold + rng.uniform(-2, 2, 60_000)) * white / 255
    rest -= colours @ np.array(weights) - colours[:, 1] * weights[1]
    colours[:, 1] = np.clip(np.rint(rest / weights[1]), 0, white)
    far = np.full((540_000, 3), white)
    return np.concatenate([colours, far]).astype(dtype)[None]


@pytest.mark.parametrize("weights", [LUMA_WEIGHTS, (0.1, 0.8, 0.1), (1 / 3, 1 / 3, 1 / 3)])
@pytest.mark.parametrize(
    ("dtype", "full_scale"), [(np.uint8, None), (np.uint16, None), (np.uint16, 4095)]
)
@pytest.mark.parametrize("threshold", [1, 105, 254])
def test_colours_close_to_the_threshold_are_on_the_right_side(
    weights, dtype, full_scale, threshold
):
    white = full_scale or np.iinfo(dtype).max
    image = around(threshold, weights, white, dtype, np.random.default_rng(1))
    expected = lin2020_steps.binarise(to_gray(image, weights, full_scale), threshold)
    assert 0.01 < np.mean(expected == 0) < 0.1
    assert np.array_equal(binarised(image, threshold, weights, full_scale), expected)


@pytest.mark.parametrize("weights", [LUMA_WEIGHTS, (0.1, 0.8, 0.1), (0.0, 0.0, 1.0)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_the_quick_average_is_as_close_as_is_claimed(weights, dtype):
    white = np.iinfo(dtype).max
    colours = np.random.default_rng(2).integers(0, white + 1, (1, 300_000, 3))
    corners = np.stack(np.meshgrid(*[[0, 1, white]] * 3), axis=-1).reshape(1, -1, 3)
    image = np.concatenate([colours, corners], axis=1).astype(dtype)
    off = np.abs(_average(image, weights) - image @ np.array(weights)).max()
    assert off <= SLACK_DN[np.dtype(dtype)]
