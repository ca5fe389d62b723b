"""The whole way from scene to bound, on few pixels and samples: equal seeds, equal derivatives."""

from __future__ import annotations

import json
from contextlib import contextmanager
from unittest import mock

import pytest
from bound_scenes import changed

from simtip.bound import tip_bound
from simtip.bound.tip import VIEW_SAMPLES
from simtip.errors import InputError
from simtip.render import Backend, choose, movable_needle

pytestmark = pytest.mark.slow

DEEP = {"bit_depth": 16, "gain_dn_per_e": 1.0, "full_well_e": 1e6}


FEW = 16
"""Samples: bounds with the same derivatives are compared, and their ratio has no noise."""


def bound_of(scene, **parts):
    spec = changed(scene, **parts)
    return tip_bound(spec, backend=choose("llvm"), samples=FEW, check=False)


class Remembered:
    """A movable needle that looks once at what it is asked again: light knows of no sensor."""

    def __init__(self, needle):
        self.views, self.band = needle.views, needle.band
        self._needle, self._found = needle, {}

    def look(self, side, pixels, move, samples, replica=0):
        arrays = pixels, move.R, move.t, samples
        told = side, replica, *(one.tobytes() for one in arrays)
        if told not in self._found:
            self._found[told] = self._needle.look(side, pixels, move, samples, replica)
        return self._found[told]


@pytest.fixture(scope="module")
def with_sensor(tip_scene):
    """Give the bound of the scene with another sensor, rendered once for all of them."""
    backend = choose("llvm")
    plain = changed(tip_scene, render={"samples": VIEW_SAMPLES})
    with movable_needle(plain, backend=backend, seed=plain.seed) as needle:
        remembered = Remembered(needle)

        @contextmanager
        def again(*_, **__):
            yield remembered

        def bound(**sensor):
            with mock.patch("simtip.bound.tip.movable_needle", again):
                return bound_of(tip_scene, sensor=sensor)

        yield bound


@pytest.fixture(scope="module")
def plain(tip_scene):
    return bound_of(tip_scene)


def ratio(one, other, key="bound_known_mm"):
    a, b = one.to_dict()[key], other.to_dict()[key]
    return [a[name] / b[name] for name in ("x", "y", "z", "norm")]


def test_what_is_rendered_once_gives_the_same_bound(with_sensor, plain):
    assert with_sensor().to_dict()["bound_mm"] == plain.to_dict()["bound_mm"]


def test_by_the_root_of_the_exposure_where_shot_noise_rules(with_sensor):
    short, long = (with_sensor(**DEEP, read_noise_e=0.0, exposure_s=t) for t in (0.05, 0.2))
    assert ratio(short, long) == pytest.approx([2.0] * 4, rel=2e-3)


def test_by_the_read_noise_where_that_rules(with_sensor):
    quiet, loud = (
        with_sensor(**DEEP, read_noise_e=e, black_level_dn=3e4) for e in (1000.0, 2000.0)
    )
    assert ratio(loud, quiet) == pytest.approx([2.0] * 4, rel=0.02)


def test_a_mosaic_takes_two_of_three_readings(with_sensor, plain):
    assert ratio(with_sensor(mosaic="rggb"), plain) == pytest.approx([3**0.5] * 4, rel=0.15)


def test_white_all_over_tells_nothing(with_sensor):
    found = with_sensor(exposure_s=20.0).to_dict()
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
