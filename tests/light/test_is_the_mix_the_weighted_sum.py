"""Is the mix the sum of its groups, exactly as before for steady light, and by row otherwise?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip.mix import mix, weights
from simtip.render import View
from simtip.spec import AmbientSpec, SensorSpec, TubeLamp


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def response(rng):
    """More rows than are worked on at a time, and not a multiple of them."""
    return rng.random((4, 75, 11, 3), dtype=np.float32)


def one_by_one(response, power):
    """As it was before there were rows: whole images, one group after the other."""
    total = np.zeros(response.shape[1:], np.float32)
    for group, weight in zip(response, power, strict=True):
        if weight.any():
            total += group * weight.astype(np.float32)
    return total


def test_steady_light_is_mixed_to_the_same_bits(response, rng):
    power = [*rng.random((3, 3)) * 20, np.zeros(3)]
    found = mix(response, power)
    assert found.dtype == np.float32
    assert np.array_equal(found, one_by_one(response, power))


@pytest.mark.parametrize("colours", ["one", "many"])
def test_every_row_has_its_own_weights(response, rng, colours):
    power = rng.random((4, 75, 3))
    if colours == "one":
        power = rng.random((4, 75, 1)) * rng.random((4, 1, 3))
    power[2, 10:60] = 0
    expected = np.einsum("grwc,grc->rwc", response.astype(np.float64), power)
    assert mix(response, list(power)) == pytest.approx(expected, rel=1e-6)


def test_rows_and_whole_images_go_together(response, rng):
    steady, rows = rng.random((2, 3)), rng.random((2, 75, 3))
    expected = np.einsum("grwc,gc->rwc", response[:2].astype(float), steady)
    expected += np.einsum("grwc,grc->rwc", response[2:].astype(float), rows)
    assert mix(response, [*steady, *rows]) == pytest.approx(expected, rel=1e-6)


def test_mixing_is_linear(response, rng):
    a, b = rng.random((2, 4, 3))
    both = mix(response, list(2 * a + 3 * b))
    apart = 2 * mix(response, list(a)) + 3 * mix(response, list(b))
    assert both == pytest.approx(apart, rel=1e-6)


def test_no_light_is_black(response):
    assert not mix(response, [np.zeros(3)] * 4).any()


@pytest.mark.parametrize(
    "power",
    [[np.ones(3)] * 3, [np.ones(3)] * 5, [np.ones((74, 3))] * 4, [np.ones(4)] * 4, [1.0] * 4],
)
def test_weights_that_do_not_fit_are_refused(response, power):
    with pytest.raises(ValueError, match="weights of the shapes"):
        mix(response, power)
    with pytest.raises(ValueError, match="a response is"):
        mix(response[0], power)


def lamps():
    ballast = {"kind": "magnetic", "ripple": 0.4, "phase_deg": 50}
    return (
        TubeLamp(name="b", centre_mm=(0, 0, 0), rgb=(1, 0.8, 0.7), power=0.3),
        TubeLamp.model_validate({"name": "a", "centre_mm": (0, 0, 0), "ballast": ballast}),
        TubeLamp(name="c", centre_mm=(0, 0, 0), spectrum="FL2"),
    )


def test_a_view_is_mixed_by_name_from_the_scene(scene, response):
    """The order of the lamps in the scene may have changed since it was rendered."""
    spec = scene.model_copy(
        update={
            "lamps": lamps(),
            "ambient": AmbientSpec(radiance_w_m2_sr=(0.1, 0.2, 0.3)),
            "sensor": SensorSpec(row_time_s=1e-4, exposure_s=0.003),
        }
    )
    plane = np.zeros((75, 11), np.float32)
    view = View(("a", "b", "c", "ambient"), response, plane, plane, plane, None, "test")
    power = weights(spec, 75)
    assert list(power) == ["b", "a", "c", "ambient"]
    expected = sum(
        group.astype(float) * np.broadcast_to(power[name], (75, 3))[:, None]
        for name, group in zip(view.lamps, response, strict=True)
    )
    assert view.radiance(spec) == pytest.approx(expected, rel=1e-6)
    dimmed = spec.model_copy(update={"lamps": (lamps()[0],)})
    with pytest.raises(KeyError):
        view.radiance(dimmed)
