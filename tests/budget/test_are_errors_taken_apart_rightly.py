"""Is an error under some causes what those causes make of it, and nothing else?

Observations are made up here: true tips moved by known amounts.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from simtip.budget.apparent import recession
from simtip.budget.causes import Cause, present
from simtip.budget.errors import Errors, Truth
from simtip.budget.observed import Observed, focuses
from simtip.spec.experiment import ExperimentSpec
from simtip.spec.recalibration import RecalibrationSpec

PLACES, REPLICATES = 6, 4
AXIS = np.array([0.0, -1.0, 0.0])
RNG = np.random.default_rng(4)


@pytest.fixture(scope="module")
def lens_scene(scene):
    """The paper's set-up with lenses that are focused somewhere."""
    lens = scene.rig.left.lens.model_copy(update={"focus_mm": 175.0})
    sides = {
        side: getattr(scene.rig, side).model_copy(update={"lens": lens})
        for side in ("left", "right")
    }
    return scene.model_copy(update={"rig": scene.rig.model_copy(update=sides)})


@pytest.fixture(scope="module")
def truth(scene):
    tips = np.array(scene.needle.tip_mm) + np.arange(PLACES)[:, None] * [0, 2.0, 0]
    laser = np.tile(np.arange(PLACES) * 2.0, (REPLICATES, 1))
    px = np.stack(scene.rig.rig().project(tips), axis=1)
    line = np.arange(PLACES)
    steps = np.stack([line[:-1], line[1:]], axis=1)
    return Truth(tips, px, AXIS, line, laser, steps, np.abs(np.diff(laser, axis=1)))


def test_a_tip_seen_short_along_the_needle_is_found_to_be(scene, truth):
    rig = scene.rig.rig()
    short = np.stack(rig.project(truth.tips_mm + 0.7 * AXIS), axis=1)
    length, common, own = recession(short, truth.true_px, truth.tips_mm, AXIS, rig)
    assert length == pytest.approx(0.7)
    assert common == pytest.approx(short - truth.true_px)
    assert np.abs(own).max() < 1e-9


def test_views_that_see_it_differently_short_have_a_mismatch(scene, truth):
    rig = scene.rig.rig()
    seen = truth.true_px.copy()
    seen[:, 0] = rig.project(truth.tips_mm + 0.9 * AXIS)[0]
    seen[:, 1] = rig.project(truth.tips_mm + 0.5 * AXIS)[1] + [0.2, 0]
    length, common, own = recession(seen, truth.true_px, truth.tips_mm, AXIS, rig)
    assert length == pytest.approx(0.7, abs=1e-3)
    assert common + own == pytest.approx(seen - truth.true_px)
    assert own[:, 0, 1].mean() < -1  # 0.2 mm towards the hub, up in the picture
    assert own[:, 1, 0] == pytest.approx(0.2, abs=0.1)


def made_up(truth, *, quantised=0.3, noise=0.1, short=8.0, defocus=1.5):
    """Give tips by state: seen short, more so out of focus, rounded, noisy."""
    found = {}
    for focus in (False, True):
        calm = truth.true_px + np.array([0, -(short + defocus * focus)])
        rounding = RNG.uniform(-quantised, quantised, truth.true_px.shape)
        shaken = RNG.normal(0, noise, (REPLICATES, *truth.true_px.shape))
        for quantisation in (False, True):
            one = calm + rounding * quantisation
            found[focus, False, False, quantisation] = one[None]
            found[focus, True, False, quantisation] = one + shaken
    return Observed(found, True, Counter())


def errors(scene, truth, seen, rig=None):
    rigs = {(c, d): [rig or scene.rig.rig()] for c in (False, True) for d in (False, True)}
    return Errors(scene, truth, seen, rigs, REPLICATES)


def test_with_no_cause_there_is_no_error(lens_scene, truth):
    found = errors(lens_scene, truth, made_up(truth)).squares(frozenset())
    assert max(values.max() for values in found.values()) < 1e-16


def test_recession_alone_is_the_length_along_the_needle(lens_scene, truth):
    found = errors(lens_scene, truth, made_up(truth))
    both = frozenset([Cause.RECESSION])
    length = found.recession_mm(both)
    assert found.squares(both)["position"][0] == pytest.approx(length**2, rel=1e-3)
    out_of_focus = found.recession_mm(frozenset([Cause.DEFOCUS]))
    assert (out_of_focus > length).all()


def test_defocus_without_recession_and_mismatch_is_nothing(lens_scene, truth):
    """It works by them alone, so its share is an interaction."""
    found = errors(lens_scene, truth, made_up(truth)).squares(frozenset([Cause.DEFOCUS]))
    assert found["position"].max() < 1e-16


def test_quantisation_and_noise_are_there_without_recession(lens_scene, truth):
    found = errors(lens_scene, truth, made_up(truth, noise=0.0))
    calm = found.squares(frozenset([Cause.QUANTISATION]))["position"]
    assert 1e-6 < calm.max() < 0.1
    assert found.squares(frozenset([Cause.NOISE]))["position"].max() < 1e-16


def test_all_causes_are_what_was_seen(lens_scene, truth):
    seen = made_up(truth)
    rig = lens_scene.rig.rig()
    from simtip.triangulate import triangulate_points

    tips = seen.tips_px[True, True, False, True]
    points = triangulate_points(tips[:, :, 0], tips[:, :, 1], rig, "svd")
    wanted = ((points - truth.tips_mm) ** 2).sum(axis=-1)
    found = errors(lens_scene, truth, seen).squares(frozenset(Cause))
    assert found["position"] == pytest.approx(wanted)


def test_the_reference_counts_in_displacements_only(lens_scene, truth):
    late = replace(
        truth,
        line_laser_mm=truth.line_laser_mm * 1.01,
        steps_laser_mm=truth.steps_laser_mm * 1.01,
    )
    found = errors(lens_scene, late, made_up(truth)).squares(frozenset([Cause.REFERENCE]))
    assert found["position"].max() < 1e-16
    assert found["step"] == pytest.approx(0.02**2)
    assert found["from_start"][0] == pytest.approx((0.01 * np.arange(2, 11, 2)) ** 2)


def test_a_place_unseen_in_any_state_does_not_count(lens_scene, truth):
    seen = made_up(truth)
    seen.tips_px[False, True, False, False][2, 3] = np.nan
    found = errors(lens_scene, truth, seen)
    assert found.kept.tolist() == [True, True, True, False, True, True]
    squares = found.squares(frozenset(Cause))
    # No step bridges it: of five there are three, and of displacements from the start four.
    assert [squares[kind].shape[1] for kind in ("position", "step", "from_start")] == [5, 3, 4]
    true = found.squares(frozenset([Cause.REFERENCE]))
    assert true["step"].max() < 1e-16


def test_without_the_start_there_is_nothing_from_it(lens_scene, truth):
    seen = made_up(truth)
    seen.tips_px[False, True, False, False][2, 0] = np.nan
    squares = errors(lens_scene, truth, seen).squares(frozenset(Cause))
    assert squares["from_start"].shape[1] == 0
    assert squares["step"].shape[1] == 4


def test_what_matching_would_refuse_is_told(lens_scene, truth):
    seen = made_up(truth, noise=0.0)
    assert errors(lens_scene, truth, seen).refused(frozenset(Cause)) == 0
    seen.tips_px[True, True, False, True][1, 2, 0, 1] += 60
    share = errors(lens_scene, truth, seen).refused(frozenset(Cause))
    assert share == pytest.approx(1 / (PLACES * REPLICATES))


def test_causes_are_those_that_the_scene_has(scene, lens_scene):
    causes, absent = present(scene, whole_pixels=True)
    assert Cause.DEFOCUS in absent
    assert Cause.CALIBRATION in absent
    assert set(causes) | set(absent) == set(Cause)
    spec = ExperimentSpec(calibration=RecalibrationSpec(distortion="none"))
    more, missing = present(lens_scene.model_copy(update={"experiment": spec}), whole_pixels=False)
    assert {Cause.DEFOCUS, Cause.CALIBRATION} <= set(more)
    assert missing[Cause.DISTORTION] == "the lenses have none"
    assert Cause.QUANTISATION in missing


def test_without_defocus_there_is_as_much_light(scene, lens_scene):
    levels = focuses(lens_scene)
    (focus, none), (own, sharp) = (
        levels[f"rig.left.lens.{name}"] for name in ("focus_mm", "f_number")
    )
    lens = lens_scene.rig.left.lens
    assert (focus, none, own) == (175.0, None, lens.f_number)
    pinhole = lens.model_copy(update={"focus_mm": None, "f_number": sharp})
    assert pinhole.working_f_number() == pytest.approx(lens.working_f_number())
    assert sharp > own
    assert focuses(scene)["rig.right.lens.focus_mm"] == [None]
