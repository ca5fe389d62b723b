"""Does the needle mirror as much of each colour as titanium does?"""

from __future__ import annotations

import numpy as np
import pytest
from regions import with_roi

from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.spec import SceneSpec, TubeLamp

WAVELENGTH_NM = (600.0, 540.0, 460.0)
TITANIUM = np.array([2.6360 + 3.6520j, 2.5079 + 3.3882j, 2.2925 + 3.0670j])
"""n + ik at those, Johnson and Christy 1974, interpolated by hand."""


def fresnel(m: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Reflectance for unpolarised light from air (Born and Wolf, section 14.2)."""
    inside = np.sqrt(m**2 - (1 - cosine**2))
    s = (cosine - inside) / (cosine + inside)
    p = (m**2 * cosine - inside) / (m**2 * cosine + inside)
    return (np.abs(s) ** 2 + np.abs(p) ** 2) / 2


def test_in_a_white_room_a_polished_needle_has_titaniums_colour(scene):
    # Rows that look at the shaft squarely: the camera's v of y = 0.
    spec = with_roi(scene, [790, 648, 60, 20], [1000, 700, 4, 4])
    data = spec.model_dump(mode="json")
    assert tuple(data["sensor"]["wavelength_nm"]) == WAVELENGTH_NM
    data["needle"]["material"]["roughness"] = 0.01
    data["lamps"] = []
    data["ambient"]["radiance_w_m2_sr"] = [1, 1, 1]
    data["background"].update(centre_mm=[0, 0, 9000], size_mm=[1, 1])  # out of the way
    view, _ = render_pair(SceneSpec.model_validate(data))
    assert view.coverage[:, 0].max() == view.coverage[:, -1].max() == 0
    # The room itself is seen beside the needle, with radiance 1.
    mirrored = view.response[-1] - (1 - view.coverage)[..., None]
    found = mirrored.sum(axis=(0, 1)) / view.coverage.sum()
    # A cylinder of radius 1 seen from afar: equally many samples at each distance u from its axis.
    u = (np.arange(4000) + 0.5) / 4000
    expected = fresnel(TITANIUM[:, None], np.sqrt(1 - u**2)).mean(axis=1)
    assert found[0] > found[1] > found[2]
    np.testing.assert_allclose(found, expected, rtol=2e-3)


LAMP = TubeLamp(name="t", centre_mm=(30, -400, -200), direction=(2, 1, 0.5), length_mm=700)
PLACES = {
    "below the middle": (20.0, 20.0, 170.0),
    "beyond the end": (900.0, 100.0, 100.0),
    "close by": (0.0, -370.0, -180.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
def test_a_tubes_density_over_directions_is_that_of_its_samples(place):
    with activated(choose()):
        from simtip.render.emitters import emitters_of
        from simtip.render.engine import mi

        (tube,) = emitters_of(LAMP)

        def vector(kind, array):
            return kind(*(mi.Float(np.ascontiguousarray(c, np.float32)) for c in array.T))

        def density(points, normals):
            x = mi.Point3f(*place)
            return tube.pdf(x, vector(mi.Point3f, points), vector(mi.Normal3f, normals)).numpy()

        # Over the whole tube by the midpoint rule, in numpy.
        axis = np.array(LAMP.direction) / np.linalg.norm(LAMP.direction)
        side = np.cross(axis, [0, 0, 1.0])
        side /= np.linalg.norm(side)
        up = np.cross(axis, side)
        along, phi = np.meshgrid((np.arange(1000) + 0.5) / 1000, (np.arange(1000) + 0.5) / 1000)
        along, phi = (along.ravel() - 0.5) * LAMP.length_mm, phi.ravel() * 2 * np.pi
        normals = np.cos(phi)[:, None] * side + np.sin(phi)[:, None] * up
        centre, radius = np.array(LAMP.centre_mm), LAMP.diameter_mm / 2
        points = centre + along[:, None] * axis + radius * normals
        to_x = np.array(place) - points
        d = np.linalg.norm(to_x, axis=1)
        facing = np.clip((to_x * normals).sum(axis=1) / d, 0, None)
        area = 2 * np.pi * radius * LAMP.length_mm / len(points)
        total = (density(points, normals) * facing / d**2).sum() * area
        assert total == pytest.approx(1, abs=2e-4)

        # The same at the points that the other technique, `sample`, gives.
        xi = np.random.default_rng(3).random((1000, 2))
        sample = tube.sample(mi.Point3f(*place), vector(mi.Point2f, xi))
        points = sample.point.numpy().T.astype(float)
        off = points - centre
        normals = (off - (off @ axis)[:, None] * axis) / radius
        lit = sample.weight.numpy() > 0
        assert lit.mean() > 0.9
        found, stated = density(points, normals)[lit], sample.pdf.numpy()[lit]
        np.testing.assert_allclose(found, stated, rtol=1e-3)
