"""Does each effect alone move what it should, by how much it should, and nothing else?

A flat field of 2000 e- at K = 2 DN/e-, 16 bit. Of a series of frames, three numbers: the mean, the
temporal variance (of a pixel, over the frames) and the spatial variance (of the pixels' own
means). With every effect off they are 4100 DN, 0 and 0; each row switches one on.
"""

from __future__ import annotations

import sys

import numpy as np
import pytest

from simtip import sensor
from simtip.seeding import stream
from simtip.spec import CameraSpec, SensorSpec

MU, K, FRAMES = 2000.0, 2.0, 40
CAMERA = CameraSpec(width=80, height=60, fx=1, fy=1, cx=0, cy=0)
N = 80 * 60 * 3
EFFECTS = ("shot_noise", "read_noise", "prnu", "dsnu", "dark_current", "full_well", "defects")
FULL = {
    "exposure_s": 0.5,
    "gain_dn_per_e": K,
    "black_level_dn": 100,
    "bit_depth": 16,
    "full_well_e": 1500,
    "read_noise_e": 7,
    "prnu_percent": 3,
    "dsnu_e": 20,
    "dark_current_e_per_s": 50,
    "dark_reference_c": 20,
    "dark_doubling_k": 8,
    "temperature_c": 44,
    "dead_fraction": 0.05,
}
DARK = 50 * 0.5 * 2**3  # 24 K are three doublings: 200 e-


def spec_of(*on, **changes):
    switches = {name: name in on for name in EFFECTS}
    return SensorSpec.model_validate({**FULL, "effects": switches, **changes})


def light_of(spec, mean_e=MU):
    per = sensor.responsivity(spec)
    return np.broadcast_to(mean_e / per, (60, 80, 3)).astype(np.float32)


def measured(spec, light):
    """Mean, temporal variance and spatial variance, DN and DN^2, of the series."""
    pattern = sensor.fixed_pattern(spec, CAMERA, "left")
    frames = np.stack(
        [
            sensor.expose(light, spec, camera=pattern, rng=stream(1, "frame", k))
            for k in range(FRAMES)
        ]
    ).astype(np.float64)
    temporal = frames.var(axis=0, ddof=1).mean()
    return frames.mean(), temporal, frames.mean(axis=0).var(ddof=1) - temporal / FRAMES


# What each effect alone should add: to the mean (DN), temporal and spatial variance (DN^2).
ROWS = {
    "none": ((), {}, (0, 0, 0)),
    "shot noise": (("shot_noise",), {}, (0, K**2 * MU + 1 / 12, 0)),
    "read noise": (("read_noise",), {}, (0, K**2 * 49 + 1 / 12, 0)),
    "PRNU": (("prnu",), {}, (0, 0, (K * 0.03 * MU) ** 2 + 1 / 12)),
    "DSNU": (("dsnu",), {}, (0, 0, (K * 20) ** 2 + 1 / 12)),
    "dark current": (("dark_current",), {}, (K * DARK, 0, 0)),
    "dark current, +8 K": (("dark_current",), {"temperature_c": 52}, (2 * K * DARK, 0, 0)),
    "full well": (("full_well",), {}, (K * (1500 - MU), 0, 0)),
    "dead pixels": (("defects",), {}, (-K * MU * 0.05, 0, (K * MU) ** 2 * 0.05 * 0.95)),
    "gain x 2": ((), {"gain_dn_per_e": 2 * K}, (K * MU, 0, 0)),
    "black level + 0.3": ((), {"black_level_dn": 100.3}, (0, 0, 0)),
    "black level + 0.6": ((), {"black_level_dn": 100.6}, (1, 0, 0)),
    "12 bit": ((), {"bit_depth": 12}, (4095 - 4100, 0, 0)),
}


def tolerances(change, expected):
    """Four standard errors, of the pixels that there are; exactly 0 where nothing is random."""
    _, temporal, spatial = expected
    dead = 0.05 * N if spatial and change == "dead pixels" else None
    mean = 4 * np.sqrt(temporal / (N * FRAMES) + spatial / N)
    if dead:  # binomial number of dead pixels: their variance's error is its mean's, scaled
        return mean, 1e-9, mean * K * MU * 0.9
    residual = 4 * temporal / FRAMES * np.sqrt(2 / N)
    return (
        mean + 1e-9,
        4 * temporal * np.sqrt(2 / (N * (FRAMES - 1))) + 1e-9,
        4 * spatial * np.sqrt(2 / N) + residual + 1e-9,
    )


def test_each_effect_alone_moves_its_own(capsys):
    base = spec_of()
    light = light_of(base)
    lines, wrong = [], []
    for change, (on, changes, expected) in ROWS.items():
        mean, temporal, spatial = measured(spec_of(*on, **changes), light)
        found = (mean - (K * MU + 100), temporal, spatial)
        allowed = tolerances(change, expected)
        good = all(abs(f - e) <= a for f, e, a in zip(found, expected, allowed, strict=True))
        wrong += [] if good else [change]
        lines.append(
            f"{change:20}"
            + " ".join(f"{e:12.3f}" for e in expected)
            + " |"
            + " ".join(f"{f:12.3f}" for f in found)
            + ("" if good else "  <-")
        )
    head = "effect alone          expected: mean DN, temporal, spatial DN^2 | found"
    with capsys.disabled():
        sys.stdout.write("\n\n" + "\n".join([head, *lines]) + "\n")
    assert not wrong


@pytest.mark.parametrize("effect", EFFECTS)
def test_a_switch_off_equals_the_figure_that_does_nothing(effect):
    """All effects on, one of them off in two ways, give the same bytes. Shot noise has no figure:
    without it and without read noise, two frames are equal."""
    off = spec_of(*(name for name in EFFECTS if name != effect))
    light = light_of(off, 1200.0)

    def frame(spec, *names):
        pattern = sensor.fixed_pattern(spec, CAMERA, "left")
        return sensor.expose(light, spec, camera=pattern, rng=stream(2, *names))

    if effect == "shot_noise":
        quiet = spec_of("prnu", "dsnu", "dark_current", "full_well", "defects")
        np.testing.assert_array_equal(frame(quiet, "a"), frame(quiet, "b"))
        return
    nothing = {
        "read_noise": {"read_noise_e": 0},
        "prnu": {"prnu_percent": 0},
        "dsnu": {"dsnu_e": 0},
        "dark_current": {"dark_current_e_per_s": 0},
        "full_well": {"full_well_e": 1e9},
        "defects": {"dead_fraction": 0},
    }[effect]
    zero = spec_of(*EFFECTS, **nothing)
    np.testing.assert_array_equal(frame(off), frame(zero))
    assert (frame(off) != frame(spec_of(*EFFECTS))).any()


def test_noise_off_is_shot_and_read_noise_off():
    spec = spec_of(*EFFECTS, noise=False)
    other = spec_of(*(name for name in EFFECTS if "noise" not in name))
    light = light_of(spec, 1200.0)
    pattern = sensor.fixed_pattern(spec, CAMERA, "left")
    first, second = (
        sensor.expose(light, each, camera=pattern, rng=stream(k))
        for k, each in enumerate((spec, other))
    )
    np.testing.assert_array_equal(first, second)
    expected = sensor.expected_dn(light, spec, camera=pattern)
    np.testing.assert_array_equal(first, np.rint(expected))


def test_dark_current_has_shot_noise_of_its_own():
    """In the dark, mean and variance grow alike: 200 e- of each."""
    spec = spec_of("shot_noise", "dark_current")
    mean, temporal, spatial = measured(spec, light_of(spec, 0.0))
    assert mean - 100 == pytest.approx(K * DARK, abs=4 * K * np.sqrt(DARK / (N * FRAMES)))
    expected = K**2 * DARK + 1 / 12
    assert temporal == pytest.approx(expected, rel=4 * np.sqrt(2 / (N * (FRAMES - 1))))
    assert abs(spatial) < 4 * expected / FRAMES * np.sqrt(2 / N)


def test_a_pixel_that_responds_more_also_has_more_shot_noise():
    """PRNU comes before the shot noise: variance over mean is K for bright and dim pixels alike.

    A tenth of the pixels has 14,400 / 10 x 39 degrees of freedom: 4 errors are 2.4 %, while 20 %
    PRNU puts 35 % in each direction between the two groups.
    """
    spec = spec_of("shot_noise", "prnu", prnu_percent=20)
    pattern = sensor.fixed_pattern(spec, CAMERA, "left")
    light = light_of(spec)
    frames = np.stack(
        [sensor.expose(light, spec, camera=pattern, rng=stream(3, k)) for k in range(FRAMES)]
    ).astype(np.float64)
    low, high = np.quantile(pattern.response, (0.1, 0.9))
    for group in (pattern.response < low, pattern.response > high):
        mean = frames.mean(axis=0)[group].mean() - 100
        variance = frames.var(axis=0, ddof=1)[group].mean() - 1 / 12
        assert variance / mean == pytest.approx(K, rel=4 * np.sqrt(2 / (group.sum() * 39)))


def test_the_full_well_clips_after_the_shot_noise_and_dsnu_and_before_the_read_noise():
    """2000 e- into 1500: every pixel holds 1500, and only the read noise is left."""
    spec = spec_of("shot_noise", "dsnu", "prnu", "dark_current", "full_well", "read_noise")
    mean, temporal, spatial = measured(spec, light_of(spec))
    expected = K**2 * 49 + 1 / 12
    assert mean == pytest.approx(K * 1500 + 100, abs=4 * np.sqrt(expected / (N * FRAMES)))
    assert temporal == pytest.approx(expected, rel=4 * np.sqrt(2 / (N * (FRAMES - 1))))
    assert abs(spatial) < 4 * expected / FRAMES * np.sqrt(2 / N)
    dark = spec_of("dark_current", "full_well", dark_current_e_per_s=1e5)
    assert measured(dark, light_of(dark, 0.0)) == (K * 1500 + 100, 0, 0)


def test_without_a_well_only_the_range_ends_it():
    spec = spec_of("shot_noise", "read_noise", bit_depth=10)
    assert (
        sensor.expose(light_of(spec, 1e9), spec, camera=sensor.UNIFORM, rng=stream(4)) == 1023
    ).all()


@pytest.mark.parametrize(
    ("bits", "kind"), [(8, np.uint8), (10, np.uint16), (12, np.uint16), (16, np.uint16)]
)
def test_the_range_is_that_of_the_bit_depth(bits, kind):
    spec = spec_of(bit_depth=bits)
    light = light_of(spec) * np.linspace(0, 40, 80, dtype=np.float32)[None, :, None]
    image = sensor.expose(light, spec, camera=sensor.UNIFORM, rng=stream(5))
    assert (image.dtype, image.min(), image.max()) == (kind, 100, 2**bits - 1)
