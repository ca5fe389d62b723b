"""Do the channels' gains do what is stated, and does the automatic one make the background gray?"""

from __future__ import annotations

import numpy as np
import pytest
from regions import with_roi

from simtip.errors import InputError
from simtip.sensor import UNIFORM, expected_dn, expose
from simtip.simulation import simulate
from simtip.spec import SceneSpec, SensorSpec

EVEN = np.full((24, 24, 3), 0.01)


@pytest.mark.parametrize("mosaic", [None, "rggb"])
def test_each_channel_has_its_own_gain(mosaic):
    plain = SensorSpec(noise=False, mosaic=mosaic, black_level_dn=10, bit_depth=16)
    balanced = plain.model_copy(update={"white_balance": (2.0, 1.0, 0.5)})
    one, other = (
        expose(EVEN, spec, camera=UNIFORM, rng=np.random.default_rng(1)).astype(float) - 10
        for spec in (plain, balanced)
    )
    np.testing.assert_allclose(other, one * [2.0, 1.0, 0.5], atol=1)


def test_gain_is_no_light():
    # The signal-to-noise ratio of shot noise is the electrons', whatever the gain.
    spec = SensorSpec(bit_depth=16, gain_dn_per_e=1.0, read_noise_e=0, exposure_s=0.01)
    balanced = spec.model_copy(update={"white_balance": (3.0, 1.0, 1.0)})
    light = np.full((200, 200, 3), 0.01)
    ratios = [
        dn.mean() / dn.std()
        for s in (spec, balanced)
        for dn in [expose(light, s, camera=UNIFORM, rng=np.random.default_rng(2))[..., 0]]
    ]
    assert ratios[1] == pytest.approx(ratios[0], rel=1e-3)


def test_the_full_well_clips_electrons_not_dn():
    spec = SensorSpec(
        bit_depth=16, gain_dn_per_e=1.0, full_well_e=1000, white_balance=(4.0, 1.0, 1.0)
    )
    bright = expected_dn(np.full((1, 1, 3), 1e3), spec, camera=UNIFORM)
    np.testing.assert_allclose(bright[0, 0], [4000, 1000, 1000])


@pytest.fixture(scope="module")
def orange(scene) -> SceneSpec:
    data = with_roi(
        scene, [800, 850, 60, 60], [1010, 850, 60, 60], noise=None, samples=8, light_step_mm=4.0
    ).model_dump(mode="json")
    for lamp in data["lamps"]:
        lamp["rgb"] = [2.0, 1.0, 0.4]
    return SceneSpec.model_validate(data)


def test_the_automatic_one_makes_the_background_gray(orange):
    sensor = SensorSpec(preset="ideal", background_dn=150, auto_white_balance=True)
    done = simulate(orange.model_copy(update={"sensor": sensor}))
    for image, view in zip(done.images, done.views, strict=True):
        level = image[view.coverage == 0].mean(axis=0)
        np.testing.assert_allclose(level, level[1], atol=1.0)
        assert level[1] == pytest.approx(150, abs=1.5)
    assert min(done.spec.sensor.white_balance) == 1


@pytest.mark.slow
def test_a_channel_without_light_cannot_be_balanced(orange):
    data = orange.model_dump(mode="json")
    for lamp in data["lamps"]:
        lamp["rgb"] = [1.0, 1.0, 0.0]
    data["ambient"]["radiance_w_m2_sr"] = [0.003, 0.003, 0.0]
    data["sensor"]["auto_white_balance"] = True
    with pytest.raises(InputError, match="no gain up to 20") as caught:
        simulate(SceneSpec.model_validate(data))
    assert caught.value.field == "sensor.auto_white_balance"
