"""White furnaces: where all around shines with radiance 1 and nothing absorbs, all looks alike."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.metal import ggx_albedo
from regions import with_roi

from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.spec import NeedleMaterial, RoomSpec, SceneSpec

ROIS = [790, 648, 48, 16], [1002, 690, 48, 16]
"""Across the shaft, seen squarely by the left camera."""
AWAY = {"centre_mm": [0, 0, 9000], "size_mm": [1, 1]}
"""A background that nobody sees."""


def furnace(scene: SceneSpec, background: dict[str, object], **material: float) -> SceneSpec:
    data = with_roi(scene, *ROIS, samples=256, noise=None, light_step_mm=1).model_dump(mode="json")
    data["lamps"] = []
    data["ambient"]["radiance_w_m2_sr"] = [1, 1, 1]
    data["background"] |= background
    data["needle"]["material"] |= material
    return SceneSpec.model_validate(data)


@pytest.fixture
def perfect_mirror(monkeypatch):
    """Every needle reflects all, whatever its angle, but keeps its roughness."""

    def build(material: NeedleMaterial, _: object) -> object:
        from simtip.render.engine import mi

        alpha = {"alpha_u": material.roughness, "alpha_v": material.roughness_along}
        if material.roughness_along is None:
            alpha = {"alpha": material.roughness}
        return mi.load_dict(
            {"type": "roughconductor", "distribution": "ggx", "material": "none", **alpha}
        )

    with activated(choose()):
        from simtip.render import needle_subject

        monkeypatch.setattr(needle_subject, "metal_bsdf", build)
        yield


@pytest.mark.parametrize(
    "alpha",
    [
        pytest.param((0.01, None), marks=pytest.mark.slow),
        pytest.param((0.2, None), marks=pytest.mark.slow),
        (0.3, 0.06),
    ],
    ids=["polished", "rough", "brushed"],
)
@pytest.mark.usefixtures("perfect_mirror")
def test_a_perfect_needle_is_lost_in_a_furnace_but_for_what_bounces_twice(scene, alpha):
    across, along = alpha
    spec = furnace(scene, AWAY, roughness=across, roughness_along=along)
    # Light that a rough surface throws against itself is lost: so much of it, by quadrature, for
    # a cylinder seen square from its side.
    u = (np.arange(40) + 0.5) / 40
    albedo = np.mean([ggx_albedo(c, (across, along or across), 100) for c in np.sqrt(1 - u**2)])
    assert (albedo > 0.998) == (across == 0.01)
    for view in render_pair(spec):
        light = view.response[-1]
        assert light.max() < 1.003
        assert np.abs(light[view.coverage == 0] - 1).max() < 1e-6
        mirrored = (light - (1 - view.coverage)[..., None]).sum(axis=(0, 1))
        np.testing.assert_allclose(mirrored / view.coverage.sum(), albedo, atol=3e-3)


def test_a_perfect_board_is_lost_in_a_furnace_but_for_the_needles_shadow(scene):
    spec = furnace(scene, {"albedo": [1, 1, 1]})
    for view in render_pair(spec):
        board = view.response[-1][view.coverage == 0]
        # The needle hides sin(a) of a long strip's light: 1.67 mm thick, 86 mm off.
        hidden = 1.67 / 2 / 85.8
        assert 1 - hidden < board.min()
        assert board.max() < 1 + 1e-4
        assert np.ptp(board) < 2e-3


@pytest.mark.slow
def test_no_wall_adds_to_the_ambient_light(scene):
    data = furnace(scene, {}).model_dump(mode="json")
    plain = render_pair(SceneSpec.model_validate(data))
    data["room"] = RoomSpec(walls=1, ceiling=1, floor=1).model_dump(mode="json")
    walled = render_pair(SceneSpec.model_validate(data))
    for one, other in zip(plain, walled, strict=True):
        np.testing.assert_array_equal(one.response, other.response)


@pytest.mark.parametrize("alpha", [0.05, pytest.param(0.3, marks=pytest.mark.slow)])
def test_a_lamp_that_fills_the_view_is_as_good_as_ambient_light(scene, alpha):
    """A panel of 40 m before a plate: its light is found by two techniques, and counted once."""
    tip = np.array([-10.0, 20.0, 170.0])
    rois = [[*np.rint(p - 6).astype(int).tolist(), 12, 12] for p in scene.rig.rig().project(tip)]
    data = furnace(scene, AWAY, roughness=alpha).model_dump(mode="json")
    data["rig"]["left"]["roi"], data["rig"]["right"]["roi"] = rois
    data["needle"] |= {"tip": {"kind": "blunt"}, "diameter_mm": 20, "axis": [0, 0, 1]}
    ambient = render_pair(SceneSpec.model_validate(data))
    data["lamps"] = [{"name": "sky", "kind": "panel", "centre_mm": [0, 0, -50],
                      "normal": [0, 0, 1], "size_mm": [4e4, 4e4]}]  # fmt: skip
    sky = render_pair(SceneSpec.model_validate(data))
    for one, other in zip(sky, ambient, strict=True):
        assert (one.coverage == 1).all()
        found, expected = (r.mean(axis=(0, 1)) for r in (one.response[0], other.response[-1]))
        np.testing.assert_allclose(found, expected, rtol=5e-3)
