"""Is gamma a rising curve that can be undone, after all that is linear, and barred from EMVA?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip.bench_camera import measure_scene_camera
from simtip.cli import main
from simtip.errors import InputError
from simtip.seeding import stream
from simtip.sensor import (
    UNIFORM,
    expected_dn,
    expose,
    gamma_curve,
    linear_dn,
    mean_electrons,
    quantise,
)
from simtip.spec import SensorSpec

GAMMAS = [0.1, 0.45, 1 / 2.2, 1.0, 2.2, 10.0]


@pytest.mark.parametrize("bits", [8, pytest.param(12, marks=pytest.mark.slow), 16])
@pytest.mark.parametrize("gamma", GAMMAS)
def test_the_curve_rises_keeps_its_ends_and_can_be_undone(gamma, bits):
    top = 2.0**bits - 1
    dn = np.linspace(0, top, 5001)
    bent = gamma_curve(dn, gamma, bits)
    assert bent[0] == 0
    assert bent[-1] == top
    assert (np.diff(bent) > 0)[dn[1:] > 0.01 * top].all()
    assert (np.diff(bent) >= 0).all()
    assert linear_dn(bent, gamma, bits) == pytest.approx(dn, rel=1e-9, abs=1e-9)
    assert bent[2500] == pytest.approx(top * 0.5**gamma)


def test_what_lies_beyond_the_range_is_clipped():
    bent = gamma_curve(np.array([-3.0, 300.0], np.float32), 0.45, 8)
    assert bent.dtype == np.float32
    assert bent.tolist() == [0, 255]


def picture(gamma, **changes):
    spec = SensorSpec.model_validate({"preset": "generic_3um2", "gamma": gamma, **changes})
    light = np.linspace(0, 0.7, 64 * 3, dtype=np.float32).reshape(8, 8, 3)
    image = expose(light, spec, camera=UNIFORM, rng=stream(3, "gamma"))
    return spec, light, image


def test_noise_is_bent_with_the_signal_and_rounded_once():
    """The same noise at 16 bit, bent by hand, gives the 16-bit picture with gamma to a DN."""
    _, _, linear = picture(1.0, bit_depth=16, gain_dn_per_e=3.0)
    _, _, bent = picture(0.45, bit_depth=16, gain_dn_per_e=3.0)
    by_hand = 65535 * (linear / 65535) ** 0.45
    slope = 0.45 * (np.maximum(linear, 1) / 65535) ** (0.45 - 1)  # of half a DN of rounding
    assert (np.abs(bent - by_hand) <= 0.5 * np.maximum(slope, 1) + 1)[linear > 20].all()
    assert not np.array_equal(bent, linear)


def test_gamma_one_changes_no_bit():
    spec, light, image = picture(1.0)
    bare = SensorSpec.model_validate({"preset": "generic_3um2"})
    assert spec == bare
    assert np.array_equal(image, expose(light, bare, camera=UNIFORM, rng=stream(3, "gamma")))


def test_the_light_and_the_electrons_stay_linear():
    (bent, light, _), (plain, _, _) = picture(0.45), picture(1.0)
    assert np.array_equal(mean_electrons(light, bent), mean_electrons(light, plain))
    level = expected_dn(light, bent, camera=UNIFORM)
    assert linear_dn(level, 0.45, 8) == pytest.approx(
        expected_dn(light, plain, camera=UNIFORM), abs=1e-9
    )
    quiet, _, image = picture(0.45, noise=False)
    assert np.array_equal(image, quantise(expected_dn(light, quiet, camera=UNIFORM), 8))


def test_the_emva_bench_refuses_it(scene, scene_path, tmp_path, capsys):
    sensor = scene.sensor.model_copy(update={"gamma": 0.45})
    with pytest.raises(InputError, match=r"sensor\.gamma: 0\.45: EMVA 1288 .* set it to 1"):
        measure_scene_camera(scene.model_copy(update={"sensor": sensor}))
    text = scene_path.read_text(encoding="utf-8").replace("sensor:\n", "sensor:\n  gamma: 0.45\n")
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SystemExit) as ended:
        main(["camera", str(path)])
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert "sensor.gamma: 0.45" in said
    assert said.count("\n") == 1
