"""Does the background get the gray level that was asked for, or is it said why not?

The level is the mean over both cameras of their own background's expected gray level.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from regions import with_roi

from simtip.errors import InputError
from simtip.exposure import (
    GRAY,
    LONGEST_S,
    SHORTEST_S,
    auto_expose,
    gray_level,
    settle_exposure,
)
from simtip.flicker import relative_output
from simtip.seeding import stream
from simtip.sensor import UNIFORM, expose
from simtip.simulation import Simulation, _Light, _open_background, simulate
from simtip.spec import SceneSpec, SensorSpec

GENERIC = {"preset": "generic_3um2"}
MAGNETIC = {"kind": "magnetic", "mains_hz": 50, "ripple": 1.0}


def pictured(scene: SceneSpec, wanted: float, **change: object) -> Simulation:
    """Corners of the paper's pictures, few samples; lenses by side, and lamps' own values."""
    small = with_roi(scene, [780, 840, 90, 60], [990, 840, 90, 60], samples=16)
    data = small.model_dump(mode="json", exclude_unset=True)
    data["sensor"] = {**GENERIC, "background_dn": wanted, **change.get("sensor", {})}
    for side in ("left", "right"):
        data["rig"][side]["lens"] = change.get(side, {})
    for lamp in data["lamps"]:
        lamp.update(change.get("lamps", {}))
    return simulate(SceneSpec.model_validate(data))


def levels(found: Simulation) -> list[float]:
    return [
        float(np.median(image[view.coverage == 0] @ [0.299, 0.587, 0.114]))
        for image, view in zip(found.images, found.views, strict=True)
    ]


@pytest.mark.parametrize("wanted", [pytest.param(60.0, marks=pytest.mark.slow), 180.0])
def test_equal_lenses_meet_it(scene, wanted):
    found = pictured(scene, wanted)
    assert np.mean(levels(found)) == pytest.approx(wanted, abs=1)
    assert found.spec.sensor.exposure_s != SensorSpec().exposure_s


@pytest.mark.slow
def test_unequal_lenses_meet_it_on_average(scene):
    found = pictured(scene, 90, left={"f_number": 1.4}, right={"f_number": 4})
    left, right = levels(found)
    assert (left + right) / 2 == pytest.approx(90, abs=1)
    # The apertures' areas, above the black level of 4 DN; the two views differ by a few per cent.
    assert (left - 4) / (right - 4) == pytest.approx((4 / 1.4) ** 2, rel=0.1)


@pytest.mark.slow
def test_unequal_lenses_are_refused_where_one_camera_saturates(scene):
    with pytest.raises(InputError, match="left background is saturated") as caught:
        pictured(scene, 180, left={"f_number": 1.4}, right={"f_number": 4})
    assert caught.value.field == "sensor.background_dn"
    assert "at most 14" in caught.value.remedy
    # What the remedy says is possible.
    found = pictured(scene, 140, left={"f_number": 1.4}, right={"f_number": 4})
    assert np.mean(levels(found)) == pytest.approx(140, abs=1)


@pytest.mark.slow
@pytest.mark.parametrize("start_s", [0.0, 0.004, 0.006])
@pytest.mark.parametrize("row_time_s", [0.0, 2e-5])
def test_light_that_ripples_meets_it_at_the_exposure_found(scene, start_s, row_time_s):
    """Bright lamps, so that the exposure is a part of the ripple's 10 ms."""
    found = pictured(
        scene,
        120,
        sensor={"start_s": start_s, "row_time_s": row_time_s},
        lamps={"ballast": MAGNETIC, "power": 30},
    )
    assert found.spec.sensor.exposure_s < 0.008
    assert np.mean(levels(found)) == pytest.approx(120, abs=1)
    # The light that the exposure found makes, worked out anew.
    irradiance = [np.pi / 4 / 1.4**2 * view.radiance(found.spec) for view in found.views]
    board = [
        np.median(light[view.coverage == 0], axis=0)
        for light, view in zip(irradiance, found.views, strict=True)
    ]
    assert gray_level(np.array(board), found.spec.sensor) == pytest.approx(120, abs=0.5)


def mean_dn(light: np.ndarray, sensor: SensorSpec) -> float:
    """Expose even fields and average: the oracle for expected levels, saturation included."""
    images = [
        expose(np.tile(one, (64, 64, 1)), sensor, camera=UNIFORM, rng=stream(3, str(k)))
        for k, one in enumerate(np.atleast_2d(light))
    ]
    return float(np.mean([image.mean(axis=(0, 1)) @ GRAY for image in images]))


@pytest.mark.parametrize("ratio", [1.0, 1.04, 3.0])
@pytest.mark.parametrize("wanted", [40.0, 120.0])
def test_the_mean_of_both_is_what_frames_show(ratio, wanted):
    light = np.array([[1e-3, 1.1e-3, 0.9e-3], [1e-3, 1.1e-3, 0.9e-3]]) * [[1.0], [ratio]]
    sensor = settle_exposure(lambda _: light, SensorSpec(**GENERIC, background_dn=wanted))
    assert mean_dn(light, sensor) == pytest.approx(wanted, abs=0.3)


def test_gamma_bends_each_cameras_level_before_the_mean():
    light = np.array([[1e-3] * 3, [4e-3] * 3])
    still = {
        "preset": "low_noise",
        "noise": False,
        "gamma": 0.5,
        "effects": {"dark_current": False},
    }
    sensor = settle_exposure(lambda _: light, SensorSpec(**still, background_dn=2000.0))
    assert mean_dn(light, sensor) == pytest.approx(2000, abs=1)


def test_neither_needle_nor_clutter_is_background(scene):
    """A stand-in for a rendered view: half clutter, a quarter needle, a quarter board."""
    coverage, clutter = np.zeros((8, 8), np.float32), np.zeros((8, 8), np.float32)
    coverage[:2], clutter[2:6] = 0.5, 0.1
    radiance = np.ones((8, 8, 3), np.float32)
    radiance[6:] = 5
    view = SimpleNamespace(coverage=coverage, clutter=clutter, radiance=lambda _: radiance)
    light = _Light(scene, (view, view), _open_background).backgrounds(scene.sensor)
    np.testing.assert_allclose(light, 5 * np.pi / 4 / 1.4**2, rtol=1e-6)


@pytest.mark.parametrize("phase_deg", [0, 90, 170, 180, 190, 300])
@pytest.mark.parametrize("scale", [1e-3, 0.02, 1.0])
def test_the_search_ends_for_any_phase_and_brightness(phase_deg, scale):
    calls = []

    def rippling(sensor: SensorSpec) -> np.ndarray:
        calls.append(sensor.exposure_s)
        part = relative_output(0.0, sensor.exposure_s, 100, 1.0, phase_deg)
        return np.full((2, 3), scale * float(part))

    sensor = settle_exposure(rippling, SensorSpec(**GENERIC, background_dn=120.0))
    assert gray_level(rippling(sensor), sensor) == pytest.approx(120, abs=0.2)
    assert len(calls) <= 16


def test_steady_light_is_found_in_one_step():
    calls = []

    def steady(sensor: SensorSpec) -> np.ndarray:
        calls.append(sensor.exposure_s)
        return np.full((2, 3), 1e-3)

    settle_exposure(steady, SensorSpec(**GENERIC, background_dn=120.0))
    assert len(calls) == 2


@pytest.mark.parametrize("light", [1e-9, 1e9])
def test_a_level_out_of_reach_names_its_field(light):
    sensor = SensorSpec(background_dn=200.0)
    for find in (auto_expose, lambda e, s: settle_exposure(lambda _: e, s)):
        with pytest.raises(InputError, match="cannot be reached") as caught:
            find(np.full((2, 3), light), sensor)
        assert caught.value.field == "sensor.background_dn"


def test_without_a_level_the_exposure_stays():
    sensor = SensorSpec(exposure_s=0.0123)
    assert settle_exposure(lambda _: np.ones((2, 3)), sensor) is sensor
    assert SHORTEST_S < sensor.exposure_s < LONGEST_S


def test_the_gray_level_grows_with_the_exposure():
    light = np.full(3, 1e-3)
    found = [gray_level(light, SensorSpec(exposure_s=t)) for t in (0.001, 0.002)]
    assert found[1] == pytest.approx(2 * found[0], rel=1e-6)
