from __future__ import annotations

import time

import numpy as np
import pytest
from target_photographs import photograph, reason, seen

from simtip.errors import InputError
from simtip.find_target import find
from simtip.target import AsymmetricCircles, Charuco, Chessboard, CircleGrid, Target

pytestmark = pytest.mark.slow

TARGETS = [
    Chessboard(5, 4, 6.0),
    Charuco(5, 4, 6.0, 4.5),
    CircleGrid(5, 4, 6.0, 3.0),
    AsymmetricCircles(3, 5, 5.0, 4.0),
]
RNG = np.random.default_rng(5)
NOTHING = {
    "black": np.zeros((120, 160), np.uint8),
    "saturated": np.full((120, 160, 3), 255, np.uint8),
    "pixel": np.full((1, 1), 7, np.uint8),
    "line": RNG.integers(0, 256, (1, 500), dtype=np.uint8),
    "small": RNG.integers(0, 256, (17, 19), dtype=np.uint8),
    "strip": RNG.integers(0, 65536, (16, 2000), dtype=np.uint16),
    "noise": RNG.integers(0, 256, (300, 400, 3), dtype=np.uint8),
    "ramp": np.tile(np.arange(400, dtype=np.uint16) * 100, (300, 1)),
    "half": np.repeat(np.array([[0, 255]], np.uint8), 200, axis=1).repeat(300, axis=0),
    "spot": np.pad(np.full((3, 3), 255, np.uint8), 150),
    "stripes": np.tile(np.repeat(np.array([0, 200], np.uint8), 10), (300, 20)),
    "checks": np.kron(np.indices((30, 40)).sum(axis=0) % 2, np.full((12, 12), 255)).astype(
        np.uint8
    ),
}


@pytest.mark.parametrize("target", TARGETS, ids=str)
@pytest.mark.parametrize("name", NOTHING)
def test_nothing_is_found_where_nothing_is(target: Target, name: str):
    before = NOTHING[name].copy()
    assert len(reason(target, NOTHING[name])) > 10
    np.testing.assert_array_equal(NOTHING[name], before)


@pytest.mark.parametrize("target", TARGETS, ids=str)
def test_the_same_answer_twice_and_the_image_as_it_was(target: Target):
    image, _ = photograph(target)
    before = image.copy()
    image.setflags(write=False)
    first, second = seen(target, image), seen(target, image)
    np.testing.assert_array_equal(first.pixels, second.pixels)
    np.testing.assert_array_equal(first.ids, second.ids)
    np.testing.assert_array_equal(image, before)


@pytest.mark.parametrize("target", TARGETS[:2], ids=str)
def test_any_kind_of_image_will_do(target: Target):
    image, _ = photograph(target, noise_dn=0.0)
    pixels = seen(target, image).pixels
    tinted = np.stack([image, image // 2, image // 3], axis=2)
    kinds = {
        "16 bit": image.astype(np.uint16) * 257,
        "10 bit in 16": image.astype(np.uint16) * 4,
        "tinted 16 bit": tinted.astype(np.uint16) * 200,
        "other layout": np.asfortranarray(image),
        "strided": np.repeat(image, 2, axis=1)[:, ::2],
    }
    for name, kind in kinds.items():
        off = np.abs(seen(target, kind).pixels - pixels).max()
        assert off < 0.05, name


def test_red_counts_less_than_green():
    """A board printed in colours: the image is taken for red, green, blue in this order."""
    target = Chessboard(7, 4, 6.0)
    image, truth = photograph(target)
    # Dark squares shine in blue, the paper in red, more strongly.
    rgb = np.stack([image, np.zeros_like(image), (255 - image) // 2], axis=2)
    assert np.abs(seen(target, rgb).pixels - truth).max() < 0.3


@pytest.mark.parametrize(
    "image",
    [np.zeros((50, 50)), np.zeros((50, 50, 4), np.uint8), np.zeros((0, 50), np.uint8)],
    ids=["float", "four channels", "empty"],
)
def test_what_is_no_image_is_refused(image: np.ndarray):
    with pytest.raises(InputError):
        find(TARGETS[0], image)


@pytest.mark.parametrize("target", TARGETS[:3], ids=str)
def test_time_is_bounded(target: Target):
    """On noise, all of it corners; about 1 s alone, so 20 s tells of a search without end."""
    noise = np.random.default_rng(1).integers(0, 256, (1024, 1400), dtype=np.uint8)
    start = time.process_time()
    assert reason(target, noise)
    assert time.process_time() - start < 20
