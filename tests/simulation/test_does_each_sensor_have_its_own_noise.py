"""Does every simulated image have noise of its own, all of it decided by the root seed?"""

from __future__ import annotations

import numpy as np
import pytest
from regions import with_roi

import simtip
from simtip.spec import SceneSpec

SEED, OTHER = 41, 42


@pytest.fixture(scope="module")
def spec(scene) -> SceneSpec:
    """Plain white board, with a corner of the needle's tip."""
    small = with_roi(scene, [800, 850, 70, 50], [1010, 850, 70, 50], samples=16)
    data = small.model_dump(mode="json")
    data["seed"] = SEED
    return SceneSpec.model_validate(data)


@pytest.fixture(scope="module")
def runs(spec):
    return simtip.simulate(spec, seed=SEED), simtip.simulate(spec, seed=OTHER)


def board(run: simtip.Simulation) -> np.ndarray:
    """Pixels (H, W) that show only the board in both images."""
    return (run.views[0].coverage == 0) & (run.views[1].coverage == 0)


@pytest.fixture(scope="module")
def noise(runs) -> list[np.ndarray]:
    """Left and right: what differs between two seeds, on the board, (n, 3) DN."""
    where = board(runs[0])
    assert where.sum() > 2000
    first, other = ([i[where].astype(float) for i in run.images] for run in runs)
    return [a - b for a, b in zip(first, other, strict=True)]


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])


def test_left_and_right_share_no_noise(noise):
    # Of n independent pairs the correlation strays by 1 / sqrt(n).
    assert abs(correlation(*noise)) < 5 / np.sqrt(noise[0].size)


def test_another_seed_is_another_exposure(spec, runs, noise):
    sensor = spec.sensor
    where = board(runs[0])
    for image, difference in zip(runs[0].images, noise, strict=True):
        mean = image[where].mean(axis=0)
        assert np.all((mean > 50) & (mean < 250))
        # EMVA 1288: shot and read noise, and rounding; twice, for two exposures.
        gain = sensor.gain_dn_per_e
        variance = 2 * (gain * mean + (gain * sensor.read_noise_e) ** 2 + 1 / 12)
        strays = 5 * np.sqrt(2 / len(difference))
        np.testing.assert_allclose(difference.var(axis=0), variance, rtol=strays)


def test_another_seed_renders_other_samples(runs):
    for a, b in zip(runs[0].views, runs[1].views, strict=True):
        on_needle = a.coverage == 1
        assert on_needle.sum() > 50
        assert np.mean(a.response[:, on_needle] != b.response[:, on_needle]) > 0.5


@pytest.mark.slow
def test_the_scenes_own_seed_gives_the_same_bits_again(spec, runs):
    again = simtip.simulate(spec)
    assert again.seed == SEED
    for k in (0, 1):
        np.testing.assert_array_equal(again.images[k], runs[0].images[k])
        np.testing.assert_array_equal(again.views[k].response, runs[0].views[k].response)
