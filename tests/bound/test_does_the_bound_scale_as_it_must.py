"""The whole way from scene to bound, on few pixels and samples: equal seeds, equal derivatives."""

from __future__ import annotations

import json

import pytest
from bound_scenes import changed

from simtip.bound import tip_bound
from simtip.errors import InputError
from simtip.render import Backend, choose

pytestmark = pytest.mark.slow

DEEP = {"bit_depth": 16, "gain_dn_per_e": 1.0, "full_well_e": 1e6}


FEW = 16
"""Samples where two bounds with the same derivatives are compared: the ratio has no noise."""


def bound_of(scene, samples=64, **parts):
    spec = changed(scene, **parts)
    return tip_bound(spec, backend=choose("llvm"), samples=samples, check=False)


@pytest.fixture(scope="module")
def plain(tip_scene):
    return bound_of(tip_scene)


def ratio(one, other, key="bound_known_mm"):
    a, b = one.to_dict()[key], other.to_dict()[key]
    return [a[name] / b[name] for name in ("x", "y", "z", "norm")]


def test_by_the_root_of_the_exposure_where_shot_noise_rules(tip_scene):
    short, long = (
        bound_of(tip_scene, FEW, sensor={**DEEP, "read_noise_e": 0.0, "exposure_s": t})
        for t in (0.05, 0.2)
    )
    assert ratio(short, long) == pytest.approx([2.0] * 4, rel=2e-3)


def test_by_the_read_noise_where_that_rules(tip_scene):
    quiet, loud = (
        bound_of(tip_scene, FEW, sensor={**DEEP, "read_noise_e": e, "black_level_dn": 3e4})
        for e in (1000.0, 2000.0)
    )
    assert ratio(loud, quiet) == pytest.approx([2.0] * 4, rel=0.02)


def test_a_mosaic_takes_two_of_three_readings(tip_scene, plain):
    assert ratio(bound_of(tip_scene, sensor={"mosaic": "rggb"}), plain) == pytest.approx(
        [3**0.5] * 4, rel=0.15
    )


def test_white_all_over_tells_nothing(tip_scene):
    found = bound_of(tip_scene, sensor={"exposure_s": 20.0}).to_dict()
    for key in ("bound_mm", "bound_known_mm"):
        assert set(found[key].values()) == {None}


def test_what_is_unknown_makes_it_no_smaller(plain):
    found = plain.to_dict()
    for free, known in (("bound_mm", "bound_known_mm"), ("bound_axis_mm", "bound_axis_known_mm")):
        for name, value in found[known].items():
            wide = found[free][name]
            assert wide is None or wide >= value, (free, name)


def test_a_cones_roll_has_no_effect_and_a_bevels_has(tip_scene, plain):
    assert "roll" in plain.information.silent()
    bevel = changed(tip_scene, needle={"tip": {"kind": "bevel", "angle_deg": 20.0}})
    assert "roll" not in bound_of(bevel).information.silent()


def test_a_view_without_the_needle_says_nothing(tip_scene):
    rig = tip_scene.model_dump()["rig"]
    rig["right"]["roi"] = (0, 1300, 50, 50)
    found = bound_of(tip_scene, rig=rig)
    data = found.to_dict()
    assert data["bound_px"]["right"] == {"along": None, "across": None}
    assert data["bound_known_px"]["left"]["across"] < 1e-2
    assert found.views["right"].map is None
    json.dumps(data, allow_nan=False)


def test_equal_seeds_give_equal_bounds(tip_scene, plain):
    assert bound_of(tip_scene).to_dict()["bound_mm"] == plain.to_dict()["bound_mm"]


def test_the_scalar_back_end_is_refused(tip_scene):
    with pytest.raises(InputError, match="--backend"):
        tip_bound(tip_scene, backend=Backend("scalar", "a test"))
