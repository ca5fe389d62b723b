"""Does glossy clutter mirror as a coat of plastic does, and show its body as Fresnel's laws let it?

The plate is a piece of clutter, the rod another, before a board that is far away or absent.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles.metal import fresnel, ggx
from regions import with_roi

from simtip.clutter import ClutterObject
from simtip.clutter.objects import GLOSSY_SIDES
from simtip.clutter.solids import tube
from simtip.geometry import Array, unit
from simtip.mix import weights
from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.spec import SceneSpec

MIDDLE = np.array([-36.0, -4.0, 246.0])
INDEX, ALPHA = 1.5, 0.15
SIDE = 4
"""Of the region that is read out, px."""
AWAY = {"centre_mm": [0, 0, 9000], "size_mm": [1, 1]}
BOX = np.array([[x, y, z] for z in (-2.0, 0.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
FACES = np.array([[4, 5, 7], [4, 7, 6], [0, 3, 1], [0, 2, 3], [0, 1, 5], [0, 5, 4],
                  [2, 7, 3], [2, 6, 7], [1, 3, 7], [1, 7, 5], [0, 6, 2], [0, 4, 6]])  # fmt: skip


def frame(angle_deg: float) -> Array:
    """Axes (3, 3) of a plate, its normal last, that the left camera sees at an angle."""
    to_eye = unit(-MIDDLE)
    across = unit(np.cross([0.0, 1.0, 0.0], to_eye))
    up = np.cross(to_eye, across)
    normal = np.cos(np.radians(angle_deg)) * to_eye + np.sin(np.radians(angle_deg)) * up
    return np.stack([across, np.cross(normal, across), normal])


def thing(vertices: Array, faces: Array, albedo: float, finish: str = "glossy") -> ClutterObject:
    return ClutterObject(
        name="thing_1", kind="rod", vertices=vertices, faces=faces, albedo=np.full(3, albedo),
        in_view=True, finish=finish, diameter_mm=1.0,
    )  # fmt: skip


def plate(angle_deg: float, albedo: float, finish: str = "glossy") -> ClutterObject:
    """A block whose front face passes through the middle."""
    return thing(MIDDLE + BOX * [6, 6, 0.5] @ frame(angle_deg), FACES, albedo, finish)


def setting(scene: SceneSpec, *lamps: dict[str, object], side: int = SIDE) -> SceneSpec:
    """All but the clutter; the needle is out of sight, all around is white."""
    rois = [
        [*np.rint(p - side / 2).astype(int).tolist(), side, side]
        for p in scene.rig.rig().project(MIDDLE)
    ]
    data = with_roi(scene, *rois, samples=256, noise=None).model_dump(mode="json")
    data["needle"]["tip_mm"] = [-10, 5000, 170]
    data["lamps"] = list(lamps)
    data["ambient"]["radiance_w_m2_sr"] = [1, 1, 1]
    data["background"] |= AWAY
    return SceneSpec.model_validate(data)


@pytest.fixture
def seen(monkeypatch):
    """Render the left view of one thing; `patch` puts something else into a module of `render`."""

    def look(spec: SceneSpec, what: ClutterObject, **patch: object):
        with activated(choose()):
            from simtip.render import pair, transport, world

            monkeypatch.setattr(pair, "objects", lambda *_: (what,))
            for name, value in patch.items():
                monkeypatch.setattr(world if hasattr(world, name) else transport, name, value)
            view, _ = render_pair(spec)
        assert view.clutter.min() == pytest.approx(1, abs=1e-6)
        return view.response.mean(axis=(1, 2), dtype=float)

    return look


@pytest.fixture
def polished():
    with activated(choose()):
        from simtip.render import world

        return {**world._COAT, "alpha": 0.005}


def quadrature(angle_deg: float) -> float:
    """What the rough coat mirrors of an even room."""
    cosine = np.cos(np.radians(angle_deg))
    wi = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
    z, phi = np.meshgrid((np.arange(1500) + 0.5) / 1500, (np.arange(720) + 0.5) * np.pi / 360)
    r = np.sqrt(1 - z**2)
    wo = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1)
    return float(2 * np.pi * ggx(wi, wo, (ALPHA, ALPHA), np.array([INDEX])).mean())


@pytest.mark.parametrize("angle_deg", [0, pytest.param(45, marks=pytest.mark.slow), 60])
def test_a_polished_coat_on_black_mirrors_by_fresnels_law(scene, seen, polished, angle_deg):
    light = seen(setting(scene), plate(angle_deg, 0.0), _COAT=polished)[-1]
    expected = fresnel(np.array(INDEX), np.cos(np.radians(angle_deg)))
    assert angle_deg > 0 or expected == pytest.approx(0.04)
    np.testing.assert_allclose(light, expected, rtol=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("angle_deg", [0, 45, 75])
def test_the_rough_coat_mirrors_what_its_integral_says(scene, seen, angle_deg):
    """At 0 degrees 0.039: what would bounce twice between its facets is lost."""
    light = seen(setting(scene), plate(angle_deg, 0.0))[-1]
    np.testing.assert_allclose(light, quadrature(angle_deg), rtol=0.01)


@pytest.mark.parametrize("angle_deg", [pytest.param(0, marks=pytest.mark.slow), 60])
def test_the_body_shows_what_the_coat_lets_through(scene, seen, angle_deg):
    spec = setting(scene)
    body = seen(spec, plate(angle_deg, 0.5))[-1] - seen(spec, plate(angle_deg, 0.0))[-1]
    through = 1 - fresnel(np.array(INDEX), np.cos(np.radians(angle_deg)))
    np.testing.assert_allclose(body, 0.5 * through, rtol=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("angle_deg", [0, 35, 60, 80])
def test_no_more_light_leaves_than_comes(scene, seen, angle_deg):
    """Rods have at most 0.6. White, by Mitsuba's approximation for light inside: 1.001."""
    spec = setting(scene)
    assert seen(spec, plate(angle_deg, 1.0))[-1].max() < 1.002
    assert seen(spec, plate(angle_deg, 0.99))[-1].max() < 1


def sky() -> dict[str, object]:
    """A panel that is all that a plate seen squarely faces."""
    normal = frame(0)[2]
    return {"name": "sky", "kind": "panel", "centre_mm": (MIDDLE + 300 * normal).tolist(),
            "normal": (-normal).tolist(), "size_mm": [1e5, 1e5]}  # fmt: skip


def as_good_as_ambient(look, spec: SceneSpec, albedo: float, **patch: object) -> None:
    ambient = look(spec, plate(0, albedo))[-1]
    data = spec.model_dump(mode="json") | {"lamps": [sky()]}
    light = look(SceneSpec.model_validate(data), plate(0, albedo), **patch)
    np.testing.assert_allclose(light[0], ambient, rtol=5e-3)
    assert light[-1].max() < 0.01 * ambient.max()


@pytest.mark.parametrize("albedo", [pytest.param(0.0, marks=pytest.mark.slow), 0.6])
def test_a_lamp_that_fills_the_view_is_as_good_as_ambient_light(scene, seen, albedo):
    """Its light is found by two techniques, and counted once."""
    as_good_as_ambient(seen, setting(scene), albedo)


@pytest.mark.slow
def test_light_counted_twice_would_be_seen(scene, seen):
    with pytest.raises(AssertionError, match="Not equal"):
        as_good_as_ambient(seen, setting(scene), 0.6, power_heuristic=lambda *_: 1)


def panel(angle_deg: float, off_deg: float) -> tuple[dict[str, object], Array, Array]:
    """A panel 60 mm wide, so far off the mirrored direction: the lamp, its mm^2 (n, 3), facing."""
    across, _, normal = frame(angle_deg)
    to_eye, turn = unit(-MIDDLE), np.radians(off_deg)
    mirrored = 2 * (normal @ to_eye) * normal - to_eye
    away = np.cos(turn) * mirrored + np.sin(turn) * np.cross(across, mirrored)
    centre = MIDDLE + 250 * away
    lamp = {"name": "panel", "kind": "panel", "centre_mm": centre.tolist(),
            "normal": (-away).tolist(), "direction": across.tolist(),
            "size_mm": [60, 60]}  # fmt: skip
    s, t = np.meshgrid(*2 * [np.arange(60) - 29.5])
    cells = centre + s.reshape(-1, 1) * across + t.reshape(-1, 1) * np.cross(away, across)
    return lamp, cells, -away


@pytest.mark.parametrize("off_deg", [0.0, 12.0, pytest.param(-12.0, marks=pytest.mark.slow)])
def test_a_lamp_in_the_coat_is_as_bright_as_its_lobe_says(scene, seen, off_deg):
    lamp, cells, facing = panel(40, off_deg)
    light = seen(setting(scene, lamp), plate(40, 0.0))[0]
    d = cells - MIDDLE
    distance = np.linalg.norm(d, axis=1)
    wo = (d / distance[:, None]) @ frame(40).T
    solid_angle = -(d @ facing) / distance**3
    wi = frame(40) @ unit(-MIDDLE)
    lobe = ggx(wi, wo, (ALPHA, ALPHA), np.array([INDEX]))[:, 0]
    np.testing.assert_allclose(light, lobe @ solid_angle, rtol=0.01)


def test_a_matt_plate_has_no_coat(scene, seen):
    light = seen(setting(scene), plate(60, 0.5, "matt"))[-1]
    np.testing.assert_allclose(light, 0.5, rtol=1e-3)


@pytest.mark.slow
def test_the_noise_of_a_rod_in_lamplight_is_as_claimed(scene, monkeypatch):
    along = unit([0.3, 1.0, 0.1])
    spine = MIDDLE + np.linspace(-20, 20, 41)[:, None] * along
    rod = thing(*tube(spine, np.full(41, 0.9), GLOSSY_SIDES), 0.4)
    lamps = [dict(lamp.model_dump(mode="json")) for lamp in scene.lamps]
    spec = setting(scene, *lamps, side=32)
    power = [np.asarray(w).reshape(-1, 3)[0] for w in weights(spec, 32).values()]
    lights, claims = [], []
    with activated(choose()):
        from simtip.render import pair

        monkeypatch.setattr(pair, "objects", lambda *_: (rod,))
        for seed in range(6):
            view, _ = render_pair(spec, seed=seed + 1)
            lights.append(np.einsum("ghwc,gc->hw", view.response.astype(float), power) / 3)
            claims.append(view.noise.sd(power) ** 2)
    on = view.clutter == 1
    assert on.sum() > 200
    true = np.var(lights, axis=0, ddof=1)[on].mean()
    ratio = np.sqrt(np.mean(claims, axis=0)[on].mean() / true)
    assert 0.85 < ratio < 1.2, f"{ratio:.2f}"
