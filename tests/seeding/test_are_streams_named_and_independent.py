"""Does a stream depend on its seed and name alone, and are different streams independent?"""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from simtip.seeding import seed32, stream


def test_asking_twice_gives_the_same_numbers_in_any_order():
    first = {name: stream(7, "sensor", name).random(5) for name in ("left", "right", "x")}
    again = {name: stream(7, "sensor", name).random(5) for name in ("x", "right", "left")}
    for name, numbers in first.items():
        np.testing.assert_array_equal(numbers, again[name])


@pytest.mark.slow
def test_another_process_gives_the_same_numbers():
    """Python's own hash of a text differs from process to process: it must play no part."""
    code = "from simtip.seeding import *; print(seed32(7, 'a'), stream(7, 'a', 3).integers(2**63))"
    printed = {
        subprocess.run(
            [sys.executable, "-c", code],
            check=True,
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONHASHSEED": salt},
        ).stdout.strip()
        for salt in ("1", "2")
    }
    assert printed == {f"{seed32(7, 'a')} {stream(7, 'a', 3).integers(2**63)}"}


def test_the_bits_are_frozen():
    """These never change: results published with a seed have to be had again with it."""
    raw = stream(1, "trial", 17, "sensor", "left").bit_generator.random_raw(2)
    assert [hex(word) for word in raw] == ["0xcedd32b3724d96f5", "0x6842fa3c8cd30af9"]
    assert seed32(1, "render", "left") == 2545408687


def test_every_name_and_seed_has_its_own_stream():
    names = [(), ("a",), ("a", "b"), ("ab",), ("b", "a"), (1,), ("1",), (1, 2), (12,), ("",)]
    names += [(256,), (2**32 + 1,), (2**64,), (-1,), ("s",), ("\x00",), ("é",)]
    starts = {stream(seed, *name).random() for seed in (0, 1, 2**63 - 1) for name in names}
    assert len(starts) == 3 * len(names)
    seeds = {seed32(seed, *name) for seed in (0, 1, 2**63 - 1) for name in names}
    assert len(seeds) == 3 * len(names)


def test_left_and_right_are_uncorrelated():
    """Of n = 200000 pairs the correlation has a standard deviation of 1/sqrt(n): 4 of them."""
    n = 200_000
    left, right, other = (
        stream(seed, "sensor", side).standard_normal(n)
        for seed, side in ((1, "left"), (1, "right"), (2, "left"))
    )
    for a, b in ((left, right), (left, other), (left[1:], right[:-1])):
        assert abs(np.corrcoef(a, b)[0, 1]) < 4 / np.sqrt(n - 1)


def test_seeds_are_spread_over_32_bits():
    """Means of 4000 uniform numbers: standard deviation 2^32 / sqrt(12 n)."""
    seeds = np.array([seed32(3, "render", k) for k in range(4000)], dtype=float)
    assert abs(seeds.mean() - 2**31) < 4 * 2**32 / np.sqrt(12 * 4000)
    assert seeds.min() >= 0
    assert seeds.max() < 2**32


def test_numpy_whole_numbers_are_whole_numbers():
    assert seed32(np.int64(5), np.uint8(3)) == seed32(5, 3)


@pytest.mark.parametrize("seed", [-1, 2**63])
def test_a_seed_out_of_range_is_refused(seed):
    with pytest.raises(ValueError, match="seed"):
        stream(seed)


@pytest.mark.parametrize(
    ("seed", "name"), [(1.0, "a"), (True, "a"), (1, 2.0), (1, None), (1, True)]
)
def test_what_is_no_name_is_refused(seed, name):
    with pytest.raises(TypeError, match="whole number"):
        seed32(seed, name)
