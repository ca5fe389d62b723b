import tracemalloc

import numpy as np
import pytest

from simtip.emva import average, summarise
from simtip.errors import InputError

HOW = {"photons": 100.0, "exposure_s": 0.01, "bit_depth": 12}


@pytest.fixture(scope="module")
def stack():
    rng = np.random.default_rng(5)
    pattern = rng.normal(500, 20, (12, 9))
    return np.rint(pattern + rng.normal(0, 3, (6, 12, 9))).astype(np.uint16)


def test_a_pair_gives_half_the_variance_of_its_difference(stack):
    level = summarise(iter(stack[:2]), **HOW)
    difference = stack[1].astype(float) - stack[0]
    assert level.variance_dn2 == pytest.approx(np.var(difference, ddof=1) / 2, rel=1e-12)
    assert level.mean_dn == pytest.approx(stack[:2].mean(), rel=1e-12)
    assert level.freedom == 12 * 9 - 1


def test_pairs_are_averaged_and_an_odd_frame_only_adds_to_the_mean(stack):
    level = summarise(iter(stack[:5]), **HOW)
    pairs = [summarise(stack[i : i + 2], **HOW).variance_dn2 for i in (0, 2)]
    assert level.variance_dn2 == pytest.approx(np.mean(pairs), rel=1e-12)
    assert level.mean_dn == pytest.approx(stack[:5].mean(), rel=1e-12)


def test_a_change_of_light_within_a_pair_is_no_noise(stack):
    drifting = stack + np.array([0, 40, 0, 80, 0, 7], dtype=np.uint16)[:, None, None]
    steady = summarise(stack, **HOW).variance_dn2
    assert summarise(drifting, **HOW).variance_dn2 == pytest.approx(steady, rel=1e-12)


def test_a_mean_frame_knows_the_noise_left_in_it(stack):
    found = average(iter(stack), **HOW)
    np.testing.assert_allclose(found.mean_dn, stack.mean(axis=0), rtol=1e-13)
    left = np.var(stack, axis=0, ddof=1).mean() / len(stack)
    assert found.residual_dn2 == pytest.approx(left, rel=1e-12)
    assert found.level == summarise(stack, **HOW)


def test_ends_of_the_range_are_counted():
    frame = np.array([[0, 4095, 1], [0, 5, 5]], dtype=np.uint16)
    level = summarise([frame, frame], **HOW)
    assert (level.zero_fraction, level.top_fraction) == (2 / 6, 1 / 6)


def test_one_buffer_may_hold_all_frames(stack):
    def grabber():
        buffer = np.empty_like(stack[0])
        for frame in stack:
            buffer[:] = frame
            yield buffer

    assert summarise(grabber(), **HOW) == summarise(stack, **HOW)
    np.testing.assert_array_equal(average(grabber(), **HOW).mean_dn, average(stack, **HOW).mean_dn)


def test_8_bit_frames_do_not_overflow():
    frames = [np.full((400, 400), value, dtype=np.uint8) for value in (255, 0)]
    frames[0][0, 0] = 0
    level = summarise(frames, photons=0, exposure_s=1, bit_depth=8)
    difference = frames[1].astype(float) - frames[0]
    assert level.variance_dn2 == pytest.approx(np.var(difference, ddof=1) / 2, rel=1e-9)


def test_memory_does_not_grow_with_the_series():
    frame = np.zeros((256, 256), dtype=np.uint16)
    peaks = []
    for count in (4, 40):
        tracemalloc.start()
        average((frame + np.uint16(i % 3) for i in range(count)), **HOW)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.05 * peaks[0]
    assert peaks[1] < 8 * frame.size * 8


@pytest.mark.parametrize(
    ("frames", "says"),
    [
        ([], "0 frames"),
        ([np.zeros((4, 4), np.uint8)], "1 frames"),
        ([np.zeros((4, 4), np.uint8), np.zeros((4, 5), np.uint8)], "(4, 5)"),
        ([np.zeros((4, 4))], "float64"),
        ([np.zeros((4, 4, 3), np.uint8)], "(4, 4, 3)"),
        ([np.full((4, 4), 4096, np.uint16)], "top code 4095"),
    ],
)
@pytest.mark.parametrize("read", [summarise, average])
def test_what_cannot_be_used_is_refused(frames, says, read):
    with pytest.raises(InputError) as caught:
        read(frames, **HOW)
    assert says in str(caught.value)
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


def test_an_impossible_bit_depth_is_refused():
    with pytest.raises(InputError, match="bit_depth"):
        summarise([], photons=0, exposure_s=1, bit_depth=17)
