"""The 99 % interval must hold the truth in 99 % of measurements: not less often, and not by width.

Of n measurements the misses are binomial (n, 0.01); the limits are those passed by a right
interval but once in 10,000.
"""

import numpy as np
import pytest
from invented_camera import CAMERAS, counting_12_bit, quiet_12_bit
from scipy import stats

from simtip.emva import Level, MeanFrame, measure_camera, plan_measurement
from simtip.emva.estimate import Z99, Line
from simtip.emva.spatial import fit_pattern
from simtip.emva.transfer import Transfer


def repeated(build, repeats):
    """Measure camera after camera of one make: new pattern, noise and black level each time."""
    make = build(shape=(32, 32))
    plan = plan_measurement(
        make, bit_depth=make.bit_depth, exposure_s=0.01, frames=4, flat_frames=8
    )
    for i in range(repeats):
        # The black level's place between two codes is chance for a user, so for the test.
        black = make.black_dn + np.random.default_rng(i).uniform(-0.5, 0.5)
        camera = build(
            shape=(32, 32), pattern_seed=2 * i + 10, noise_seed=2 * i + 11, black_dn=black
        )
        yield camera, measure_camera(camera, plan)


def check_coverage(pairs, keys):
    misses = dict.fromkeys(keys, 0)
    scores = {key: [] for key in keys}
    for camera, found in pairs:
        for key, truth in keys.items():
            estimate = getattr(found, key)
            misses[key] += not estimate.covers(getattr(camera, truth))
            half = (estimate.high - estimate.low) / 2
            scores[key].append((estimate.value - getattr(camera, truth)) / (half / Z99))
    repeats = len(scores["K_dn_per_e"])
    most = stats.binom.ppf(0.9999, repeats, 0.01)
    for key in keys:
        assert misses[key] <= most, f"{key}: {misses[key]} of {repeats} missed, at most {most:g}"
    return scores


KEYS = {
    "K_dn_per_e": "K",
    "sigma_d_e": "sigma_d_e",
    "dark_current_e_per_s": "dark_e_per_s",
    "dark_current_by_variance_e_per_s": "dark_e_per_s",
    "full_well_e": "full_well_e",
    "prnu_percent": "prnu_percent",
    "dsnu_e": "dsnu_e",
    "quantum_efficiency": "eta",
}


def check_scale(scores, keys):
    """The scores are standard normal: the intervals are neither too narrow nor padded."""
    for key in keys:
        count = len(scores[key])
        # 4 standard errors each; 10 % more for the approximations of the intervals.
        mean, width = np.mean(scores[key]), np.std(scores[key])
        said = f"{key}: scores {mean:+.2f} +- {width:.2f}"
        assert abs(mean) < 4 / np.sqrt(count) + 0.1, said
        assert abs(width - 1) < 4 / np.sqrt(2 * count) + 0.1, said


@pytest.mark.slow
@pytest.mark.parametrize("name", [*CAMERAS, "counting"])
def test_of_four_cameras(name):
    scores = check_coverage(repeated({**CAMERAS, "counting": counting_12_bit}[name], 300), KEYS)
    # In 8 bit these few frames bound DSNU from above only: its scores are cut off at 0.
    check_scale(scores, [key for key in KEYS if key != "dsnu_e" or name != "8 bit"])


def test_of_one_camera_quickly():
    scores = check_coverage(repeated(quiet_12_bit, 20), KEYS)
    check_scale(scores, KEYS)


def test_of_patterns_whose_offsets_are_as_large_as_their_responses():
    """Both variances see the same offsets: their errors partly cancel in the PRNU."""
    pixels, signal, spread = (40, 40), 2000.0, 30.0
    line = Line(4.0, 0.5, np.zeros((2, 2)), 0.0)
    transfer = Transfer(line, line, None, None, 0.0, 0.0, 0.0, (True,), dark_resolved=True,
                        saturation=0)  # fmt: skip
    rng = np.random.default_rng(7)

    def flat(mean, picture):
        level = Level(mean, 0.01, mean, 4.0 + 0.5 * mean, 16, picture.size)
        residual = level.variance_dn2 / level.frames
        noise = np.sqrt(residual) * rng.standard_normal(pixels)
        return MeanFrame(level, picture + mean + noise, residual)

    scores = {"offset": [], "gain": []}
    for _ in range(800):
        offset = spread * rng.standard_normal(pixels)
        response = spread / signal * rng.standard_normal(pixels)
        frames = (flat(0.0, offset), flat(signal, offset + signal * response))
        found = fit_pattern(frames, transfer, 2 * signal)
        scores["offset"].append((found.offset_dn2 - spread**2) / found.offset_variance**0.5)
        error = found.gain - (spread / signal) ** 2
        scores["gain"].append(error / found.gain_variance**0.5)
    for key, score in scores.items():
        assert abs(np.mean(score)) < 4 / np.sqrt(800) + 0.1, key
        assert abs(np.std(score) - 1) < 4 / np.sqrt(1600) + 0.02, f"{key}: {np.std(score):.2f}"
