"""Are an experiment's figures those of Eq. 1 to 3 and 23, worked out here by plain loops?"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from simtip.errors import InputError
from simtip.experiment.analysis import analyse
from simtip.experiment.performed import Measured
from simtip.experiment.series import series_of, zipped_shots
from simtip.spec.experiment import ExperimentSpec, ScheduleSpec, SetupSpec, StageSpec
from simtip.sweep.campaign import cores

PLAN = {"schedule": ScheduleSpec(registration=None)}


def experiment(scene, **said):
    return scene.model_copy(update={"experiment": ExperimentSpec(**{**PLAN, **said})})


def none(_):
    return 0.0


def measured(scene, errors=none, seed=1):
    """Measure every series with given errors (runs, positions, 3), mm."""
    found = []
    for series in series_of(scene, seed):
        tips = series.tip_mm + errors(series)
        status = np.where(np.isfinite(tips).all(axis=-1), "ok", "left_no_tip").astype(object)
        found.append(Measured(series, tips, status, Counter()))
    return found


def analysed(scene, errors=none):
    axes = scene.experiment.stage.axes(scene.needle.axis)
    return analyse(scene.experiment, measured(scene, errors), axes)


def noise(seed=5, sd=0.05):
    def errors(series):
        return np.random.default_rng(seed).normal(0, sd, series.tip_mm.shape)

    return errors


def test_a_perfect_measurement_has_only_the_interferometers_error(scene):
    told = analysed(experiment(scene)).to_dict()
    assert told["accuracy"]["max_abs_mm"] < 1e-5
    assert abs(told["agreement"]["bias_mm"]) < 1e-5
    assert told["repeatability"]["p_t_percent"] < 1e-6
    assert told["detection"] == {"measurements": 75, "rate": 1.0, "failed": {}}
    assert told["position"]["rms_mm"] < 1e-12


def test_steps_and_displacements_are_distances(scene):
    whole = experiment(scene)
    found = analysed(whole, noise())
    part = measured(whole, noise())[0]
    tips, laser = part.tip_mm, part.series.laser_mm
    steps = [
        np.linalg.norm(tips[0, k + 1] - tips[0, k]) - abs(laser[0, k + 1] - laser[0, k])
        for k in range(14)
    ]
    assert found.accuracy.errors.mean_abs == pytest.approx(np.mean(np.abs(steps)))
    assert found.accuracy.errors.max_abs == pytest.approx(np.max(np.abs(steps)))
    moved = [
        np.linalg.norm(tips[r, k] - tips[r, 0]) - abs(laser[r, k] - laser[r, 0])
        for r in range(5)
        for k in range(1, 15)
    ]
    assert len(moved) == 70
    assert found.agreement.limits.bias == pytest.approx(np.mean(moved))
    assert found.agreement.limits.sd == pytest.approx(np.std(moved, ddof=1))


def test_p_t_pools_70_displacements(scene):
    whole = experiment(scene)
    found = analysed(whole, noise()).repeatability
    tips = measured(whole, noise())[0].tip_mm
    moved = np.linalg.norm(tips[:, 1:] - tips[:, :1], axis=-1)
    sigma = np.sqrt(np.mean(np.var(moved, axis=0, ddof=1)))
    assert found.measurements == 70
    assert found.sigma == pytest.approx(sigma)
    assert found.p_t_percent == pytest.approx(100 * 6 * sigma / 0.62)


def test_single_steps_see_play_at_every_turn_and_runs_only_at_their_start(scene):
    schedule = ScheduleSpec(registration=None, accuracy_turns=True)
    stage = StageSpec(needle_play_mm=-0.29, resolution_mm=0)
    found = analysed(experiment(scene, schedule=schedule, stage=stage))
    assert found.accuracy.errors.n == 14
    assert found.accuracy.errors.mean == pytest.approx(0.29, abs=1e-5)
    assert found.agreement.limits.bias == pytest.approx(0.29, abs=1e-5)
    one_way = analysed(experiment(scene, stage=stage))
    assert one_way.accuracy.errors.mean == pytest.approx(0.29 / 14, abs=1e-5)


def test_set_ups_are_the_operators(scene):
    setups = (SetupSpec(name="a"), SetupSpec(name="b"))
    shift = {"as in the scene": 1.0, "a": 1.01, "b": 0.98}

    def scaled(series):
        # About the first place, which stays: displacements are longer or shorter.
        spread = series.tip_mm - series.tip_mm[:, :1]
        return (shift[series.name] - 1) * spread + noise(7, 0.001)(series)

    found = analysed(experiment(scene, setups=setups), scaled)
    assert found.grr is not None
    assert found.grr.shape == (15, 3, 2)
    assert not found.grr.anova.pooled
    assert found.grr.sd("ev") == pytest.approx(0.001, rel=0.4)
    assert found.grr.sd("interaction") > 0.05


def test_one_set_up_is_no_gauge_study(scene):
    told = analysed(experiment(scene)).to_dict()
    assert told["grr"] is None
    assert "set-up" in told["left_out"]["grr"]


def test_the_registration_finds_the_stages_frame(scene):
    schedule = ScheduleSpec(registration=(2, 2, 2))
    stage = StageSpec(direction=(0.1, 1, 0.2), origin_mm=(1, 2, 3), resolution_mm=0)
    found = analysed(experiment(scene, schedule=schedule, stage=stage)).frame
    assert found is not None
    assert found.rotation_error_deg < 1e-5
    assert found.registration.fre < 1e-9
    assert found.position.max_mm < 1e-9
    # It speaks of absolute error: a constant one is the frame's, one that grows is not.
    moved = analysed(experiment(scene, schedule=schedule, stage=stage), lambda _: [0.5, -1, 2])
    assert moved.frame.position.max_mm < 1e-9
    grown = analysed(
        experiment(scene, schedule=schedule, stage=stage),
        lambda series: 0.01 * (series.tip_mm - scene.needle.tip_mm),
    )
    assert grown.frame.position.max_mm > 0.05


def test_what_was_not_seen_is_left_out_and_said(scene):
    def errors(series):
        off = np.zeros(series.tip_mm.shape)
        off[1, 3] = np.nan
        off[2, 0] = np.nan  # a run without its start
        return off

    found = analysed(experiment(scene), errors)
    told = found.to_dict()
    assert told["agreement"]["n"] == 70 - 1 - 14
    assert told["detection"]["failed"] == {"left_no_tip": 2}
    assert told["accuracy"]["n"] == 14
    assert any("2 measurements" in note for note in told["notes"])


def test_nothing_seen_is_the_users_affair(scene):
    with pytest.raises(InputError, match=r"0 displacements.*75 left_no_tip"):
        analysed(experiment(scene), lambda series: np.full(series.tip_mm.shape, np.nan))


def test_each_distinct_place_is_one_pair_of_images_but_for_noise(scene):
    own, *_ = series_of(experiment(scene, stage=StageSpec(backlash_mm=0.1)), 1)
    shots, shot, turn = own.shots()
    assert len(shots) == 15
    assert turn.max() == 4
    assert (shot == shot[0]).all()
    scattered, *_ = series_of(experiment(scene, stage=StageSpec(positioning_mm=0.001)), 1)
    assert len(scattered.shots()[0]) == 75


def test_every_pair_of_images_has_its_own_moment(scene):
    schedule = ScheduleSpec(registration=None, start_jitter_s=0.01)
    own, *_ = series_of(experiment(scene, schedule=schedule), 1)
    shots, _, turn = own.shots()
    starts = np.array([start for _, start in shots])
    assert len(shots) == 75
    assert turn.max() == 0
    assert len({tip for tip, _ in shots}) == 15
    assert 0 <= starts.min() < 0.001
    assert 0.009 < starts.max() < 0.01
    # Two cores take turns at two places, so that each has its light at hand.
    said = zipped_shots(shots)
    assert sorted(map(str, said["needle.tip_mm"])) == sorted(str(list(tip)) for tip, _ in shots)
    few = min(cores(), 15)
    assert len({tuple(tip) for tip in said["needle.tip_mm"][: 5 * few]}) == few


def test_a_stroke_out_of_the_picture_is_refused_before_anything_runs(scene):
    far = experiment(
        scene,
        stage=StageSpec(direction=(1, 0, 0), stroke_mm=(100, 1, 1)),
        schedule=ScheduleSpec(registration=None, step_mm=7),
    )
    with pytest.raises(InputError, match="out of the right image") as caught:
        series_of(far, 1)
    assert caught.value.field == "experiment.stage.origin_mm"
