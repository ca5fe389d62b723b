"""Does as much light arrive as physics says?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.render.metal import METALS, at_wavelengths, normal_reflectance
from simtip.spec import SceneSpec, TubeLamp

OPEN_POINTS_MM = np.array([[200.0, 100.0], [-250.0, 0.0], [0.0, -300.0], [300.0, 300.0]])
"""Points of the board that no shadow reaches."""


def tube_irradiance(lamp: TubeLamp, point: np.ndarray, normal: np.ndarray) -> float:
    """Irradiance / pi per unit radiance by the midpoint rule over the whole tube."""
    steps = 300
    x = ((np.arange(steps) + 0.5) / steps - 0.5) * lamp.length_mm
    phi = (np.arange(steps) + 0.5) / steps * 2 * np.pi
    x, phi = np.meshgrid(x, phi)
    outwards = np.stack([np.zeros_like(phi), np.cos(phi), np.sin(phi)], axis=-1)
    surface = np.array(lamp.centre_mm) + outwards * lamp.diameter_mm / 2
    surface[..., 0] += x
    to_lamp = surface - point
    d2 = (to_lamp**2).sum(axis=-1)
    direction = to_lamp / np.sqrt(d2)[..., None]
    cosines = np.clip(direction @ normal, 0, None)
    cosines = cosines * np.clip(-(outwards * direction).sum(axis=-1), 0, None)
    area = lamp.diameter_mm / 2 * (2 * np.pi / steps) * (lamp.length_mm / steps)
    return float((cosines / d2).sum() * area / np.pi)


def test_a_tube_lights_the_board_as_the_integral_says(scene):
    assert all(lamp.direction == (1, 0, 0) for lamp in scene.lamps)
    with activated(choose()):
        from simtip.render.illuminator import Illuminator
        from simtip.render.needle_subject import NeedleSubject
        from simtip.render.progress import Tally
        from simtip.render.world import load_world

        world = load_world(scene, 1, NeedleSubject(scene))
        light = Illuminator(world.scene, world.lamps, world.surround, world.board, 50.0)
        found, shadowed = light.lamps(OPEN_POINTS_MM, 16384, 1, Tally(None))
    assert not shadowed.any()
    points = world.board.points(OPEN_POINTS_MM)
    for k, lamp in enumerate(scene.lamps):
        expected = [tube_irradiance(lamp, point, world.board.normal) for point in points]
        # 16384 stratified samples of a smooth integrand leave less than 1e-4.
        np.testing.assert_allclose(found[:, k], expected, rtol=2e-4)


def test_a_room_of_unit_radiance_lights_an_open_board_by_its_albedo(small_scene):
    data = small_scene.model_dump(mode="json")
    data["lamps"] = []
    data["ambient"]["radiance_w_m2_sr"] = [1.0, 1.0, 1.0]
    data["needle"]["diameter_mm"] = 0.01  # as good as no needle
    data["background"]["albedo"] = [0.2, 0.5, 0.9]
    spec = SceneSpec.model_validate(data)
    left, _ = render_pair(spec)
    open_pixels = left.coverage == 0
    assert open_pixels.sum() > 1000
    radiance = left.radiance(spec)[open_pixels].mean(axis=0)
    # The thin needle still hides about 2e-5 of the room.
    np.testing.assert_allclose(radiance, [0.2, 0.5, 0.9], rtol=2e-4)


@pytest.mark.slow
def test_an_unlit_lamp_gives_none_of_its_light(small_scene):
    left, _ = render_pair(small_scene)
    data = small_scene.model_dump(mode="json")
    data["lamps"][1]["power"] = 0.0
    one = left.radiance(SceneSpec.model_validate(data))
    data["lamps"][0]["power"], data["lamps"][1]["power"] = 0.0, 1.0
    data["ambient"]["radiance_w_m2_sr"] = [0.0, 0.0, 0.0]
    other = left.radiance(SceneSpec.model_validate(data))
    assert other.max() > 0
    np.testing.assert_allclose(one + other, left.radiance(small_scene), rtol=1e-5)


def test_a_lamps_radiance_is_its_power_over_pi_times_its_area():
    lamp = TubeLamp(name="t", centre_mm=(0, 0, 0), radiant_power_w=10, power=0.5, rgb=(1, 2, 1))
    area_m2 = np.pi * 0.026 * 1.2
    assert lamp.radiance().sum() == pytest.approx(5 / (np.pi * area_m2))
    assert lamp.radiance()[1] == pytest.approx(2 * lamp.radiance()[0])


def test_titanium_reflects_what_its_data_set_says():
    n, k = at_wavelengths(METALS["titanium"], [397, 549, 704])
    reflectance = normal_reflectance(n, k)
    # Fresnel from (n, k) = (2.08, 2.95), (2.54, 3.43), (2.86, 3.96), by hand.
    np.testing.assert_allclose(reflectance, [0.5422, 0.5815, 0.6259], atol=5e-4)
