"""Is a ripple's mean over the exposure right, by row, by lamp, and none where it should be none?"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy import integrate

from simtip.flicker import Waveform, relative_output
from simtip.mix import weights
from simtip.spec import AmbientSpec, Ballast, SceneSpec, SensorSpec, TubeLamp

HARMONICS = ((1.0, 0.0), (0.3, 40.0), (0.0, 0.0), (0.12, -75.0))
SHAPES = {
    "cosine": Waveform("cosine"),
    "rectified_sine": Waveform("rectified_sine"),
    "harmonics": Waveform("harmonics", HARMONICS),
}


def instant(kind, ripple_hz, phase_deg):
    """The waveform at a moment, written down anew; not yet scaled to a ripple."""

    def cosine(t):
        return 1 + np.cos(2 * np.pi * ripple_hz * t + np.deg2rad(phase_deg))

    def rectified(t):
        return np.abs(np.cos(np.pi * ripple_hz * t + np.deg2rad(phase_deg) / 2))

    def harmonics(t):
        x = 2 * np.pi * ripple_hz * t + np.deg2rad(phase_deg)
        return sum(a * np.cos(k * x + np.deg2rad(p)) for k, (a, p) in enumerate(HARMONICS, start=1))

    return {"cosine": cosine, "rectified_sine": rectified, "harmonics": harmonics}[kind]


def scaled(kind, wave, ripple, period):
    """Bring a waveform to mean 1 and the ripple wanted."""
    if kind == "rectified_sine":  # its dip is too sharp to be found by looking
        mean, low, high = 2 / np.pi, 0.0, 1.0
    else:
        value = wave(np.arange(200_000) * period / 200_000)
        mean, low, high = value.mean(), value.min(), value.max()
    # 1 + s (wave - mean) has (max - min) / (max + min) = ripple.
    s = 2 * ripple / ((high - low) - ripple * (high + low - 2 * mean))
    return lambda t: 1 + s * (wave(t) - mean)


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize(
    ("start", "exposure", "hz", "ripple", "phase"),
    [
        (0.0, 1e-3, 100, 0.3, 0.0),
        (0.0123, 4.7e-3, 100, 1.0, 77.0),
        (-3.21, 0.0131, 120, 0.55, -200.0),
        (12.5, 0.0477, 120, 0.2, 1000.0),
    ],
)
def test_the_mean_is_that_of_numerical_integration(kind, start, exposure, hz, ripple, phase):
    wave = scaled(kind, instant(kind, hz, phase), ripple, 1 / hz)
    first = np.floor(start * hz + phase / 360) - 1
    dips = (first + 0.5 + np.arange(12) - phase / 360) / hz
    edges = np.unique([start, *np.clip(dips, start, start + exposure), start + exposure])
    area = sum(integrate.quad(wave, a, b, epsabs=1e-13, limit=200)[0] for a, b in pairwise(edges))
    found = relative_output(start, exposure, hz, ripple, phase, SHAPES[kind])
    assert found == pytest.approx(area / exposure, abs=2e-8)


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("ripple", [0.05, 0.4, 1.0])
def test_ripple_is_the_modulation_depth(kind, ripple):
    """Exposures of 1e-7 periods sample the waveform itself, its sharp dips included."""
    start = np.linspace(0, 0.01, 20_001)
    light = relative_output(start, 1e-9, 100, ripple, 36, SHAPES[kind])
    depth = (light.max() - light.min()) / (light.max() + light.min())
    assert depth == pytest.approx(ripple, abs=2e-6)
    assert light.min() >= -1e-9
    assert light[:-1].mean() == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("kind", ["cosine", "rectified_sine"])
def test_the_phase_is_counted_from_the_peak(kind):
    light = relative_output(np.linspace(0, 0.01, 361), 1e-9, 100, 0.5, -90, SHAPES[kind])
    assert light.argmax() == 90


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("mains_hz", [50, 60])
@settings(derandomize=True, deadline=None, max_examples=25)
@given(periods=st.integers(1, 40), start=st.floats(-100, 100), phase=st.floats(-720, 720))
def test_whole_half_periods_of_the_mains_see_no_ripple(kind, mains_hz, periods, start, phase):
    exposure = periods / (2 * mains_hz)
    found = relative_output(start, exposure, 2 * mains_hz, 1.0, phase, SHAPES[kind])
    assert abs(float(found) - 1) <= 1e-12


def test_an_electronic_ballast_has_none():
    steady = Ballast(kind="electronic")
    assert np.array_equal(steady.relative(np.linspace(0, 1, 50), 1e-4), np.ones(50))
    assert Ballast() == Ballast(kind="electronic")
    assert not Ballast(kind="magnetic", ripple=0).ripples


@pytest.mark.parametrize("field", [{"ripple": 1.0}, {"phase_deg": 90.0}, {"mains_hz": 60.0}])
def test_a_ripple_without_a_magnetic_ballast_is_refused(field):
    (name,) = field
    with pytest.raises(ValidationError, match=f"{name}: .* kind: magnetic"):
        Ballast(**field)


def scene_of(scene: SceneSpec, lamps, **sensor) -> SceneSpec:
    return scene.model_copy(
        update={"lamps": tuple(lamps), "sensor": SensorSpec.model_validate(sensor)}
    )


def tube(name="t", **fields):
    return TubeLamp.model_validate({"name": name, "centre_mm": (0, -1000, 0), **fields})


MAGNETIC = {"kind": "magnetic", "mains_hz": 50, "ripple": 0.5}


def test_each_lamp_ripples_in_its_own_phase(scene):
    """Three phases of the mains: the ripples cancel in the sum."""
    lamps = [
        tube(name, ballast={**MAGNETIC, "phase_deg": phase})
        for name, phase in (("a", 0), ("b", 240), ("c", 120))
    ]
    spec = scene_of(scene, lamps, exposure_s=0.002)
    light = {name: weight for name, weight in weights(spec, 4).items() if name != "ambient"}
    assert all(weight.shape == (3,) for weight in light.values())
    assert abs(light["a"][0] / lamps[0].radiance()[0] - 1) > 0.3
    mean = np.mean(list(light.values()), axis=0)
    assert mean == pytest.approx(lamps[0].radiance(), rel=1e-12)


def test_a_rolling_shutter_makes_bands_of_the_ripples_period(scene):
    """Period in rows: 1 / (2 f row_time). Depth: the ripple, less what the exposure averages."""
    row_time, rows, exposure = 25e-6, 4000, 0.003
    spec = scene_of(
        scene, [tube(ballast=MAGNETIC)], row_time_s=row_time, exposure_s=exposure, start_s=0.7
    )
    light = weights(spec, rows)["t"]
    assert light.shape == (rows, 3)
    period = 1 / (2 * 50 * row_time)
    assert period == 400
    signal = light[:, 1] / light[:, 1].mean() - 1
    spectrum = np.abs(np.fft.rfft(signal))
    assert spectrum.argmax() == rows / period
    depth = 0.5 * np.sinc(2 * 50 * exposure)
    assert spectrum.max() * 2 / rows == pytest.approx(depth, rel=1e-9)
    assert np.array_equal(light[:, 0] / light[:, 1], np.ones(rows))


def test_a_row_sees_what_a_global_shutter_sees_at_its_time(scene):
    lamp = tube(ballast={**MAGNETIC, "waveform": "rectified_sine", "phase_deg": 33})
    rolling = scene_of(scene, [lamp], row_time_s=13e-6, exposure_s=0.004, start_s=0.1)
    light = weights(rolling, 300)["t"]
    for row in (0, 1, 299):
        alone = scene_of(scene, [lamp], exposure_s=0.004, start_s=0.1 + 13e-6 * row)
        assert weights(alone, 300)["t"] == pytest.approx(light[row], rel=1e-12)


def test_a_rolling_shutter_without_ripple_or_with_whole_periods_shows_no_bands(scene):
    steady = scene_of(scene, [tube()], row_time_s=25e-6)
    assert weights(steady, 100)["t"].shape == (3,)
    whole = scene_of(scene, [tube(ballast=MAGNETIC)], row_time_s=25e-6, exposure_s=0.05)
    light = weights(whole, 100)["t"]
    assert np.abs(light / tube().radiance() - 1).max() <= 1e-12


def test_the_ambient_light_is_steady(scene):
    spec = scene_of(scene, [tube(ballast=MAGNETIC)], row_time_s=25e-6)
    spec = spec.model_copy(update={"ambient": AmbientSpec(radiance_w_m2_sr=(1, 2, 3))})
    assert np.array_equal(weights(spec, 9)["ambient"], [1, 2, 3])


@pytest.mark.parametrize(
    "wrong",
    [
        {"kind": "magnetic", "ripple": 1.1},
        {"kind": "magnetic", "ripple": -0.1},
        {"kind": "magnetic", "mains_hz": 0},
        {"kind": "choke"},
        {"kind": "magnetic", "waveform": "harmonics"},
        {"kind": "magnetic", "waveform": "harmonics", "harmonics": ((0, 0),)},
        {"kind": "magnetic", "harmonics": ((1, 0),)},
    ],
)
def test_an_impossible_ballast_is_refused(wrong):
    with pytest.raises(ValidationError):
        Ballast.model_validate(wrong)
