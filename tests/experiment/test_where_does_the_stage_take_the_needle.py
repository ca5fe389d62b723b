"""Is a stage's motion what its errors say, and nothing else?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip.errors import InputError
from simtip.experiment.stage import coordinates, drive, grid, positions_of
from simtip.spec.experiment import ScheduleSpec, StageSpec

STEPS = positions_of(ScheduleSpec())


def driven(runs=3, positions=STEPS, **errors):
    stage = StageSpec(**{"resolution_mm": 0.0, **errors})
    return drive(stage, np.tile(positions, (runs, 1)), np.random.default_rng(1))


def test_without_errors_it_stops_where_it_was_told_to():
    motion = driven()
    assert motion.commanded_mm.shape == (3, 15)
    assert (motion.commanded_mm[0] == np.arange(0, 30, 2)).all()
    assert (motion.carriage_mm == motion.commanded_mm).all()
    assert (motion.needle_mm == motion.commanded_mm).all()


def test_resolution_rounds_to_whole_steps():
    motion = driven(resolution_mm=0.3)
    whole = motion.carriage_mm / 0.3
    assert whole == pytest.approx(np.round(whole), abs=1e-9)
    assert np.abs(motion.carriage_mm - motion.commanded_mm).max() <= 0.15 + 1e-9


def test_a_run_that_begins_backward_loses_the_backlash_in_its_first_step():
    motion = driven(backlash_mm=0.1)
    steps = np.diff(motion.carriage_mm, axis=1)
    assert steps[:, 0] == pytest.approx(1.9)
    assert steps[:, 1:] == pytest.approx(2.0)
    # The needle follows the carriage, and all runs are alike.
    assert (motion.needle_mm == motion.carriage_mm).all()
    assert (motion.carriage_mm == motion.carriage_mm[0]).all()


def test_an_overrun_beyond_the_backlash_takes_it_away():
    steps = np.diff(driven(backlash_mm=0.1, overrun_mm=0.2).carriage_mm, axis=1)
    assert steps == pytest.approx(2.0)


def test_an_overrun_below_the_backlash_takes_its_part():
    steps = np.diff(driven(backlash_mm=0.1, overrun_mm=0.04).carriage_mm, axis=1)
    assert steps[:, 0] == pytest.approx(2 - 0.06)


@pytest.mark.parametrize("play", [0.29, -0.29])
def test_play_of_the_needle_is_unseen_by_the_carriage(play):
    motion = driven(needle_play_mm=play)
    assert (motion.carriage_mm == motion.commanded_mm).all()
    steps = np.diff(motion.needle_mm, axis=1)
    assert steps[:, 0] == pytest.approx(2 - play)
    assert steps[:, 1:] == pytest.approx(2.0)


def test_single_steps_turn_round_before_each():
    ends = np.stack([STEPS[:-1], STEPS[1:]], axis=1)
    motion = drive(StageSpec(needle_play_mm=-0.29, resolution_mm=0), ends, np.random.default_rng(0))
    assert np.diff(motion.needle_mm, axis=1) == pytest.approx(2.29)


def test_stops_scatter_as_they_are_said_to():
    motion = driven(runs=2000, positioning_mm=0.01)
    off = motion.carriage_mm - motion.commanded_mm
    assert off.std() == pytest.approx(0.01, rel=0.02)
    assert abs(off.mean()) < 4 * 0.01 / np.sqrt(off.size)


def test_straightness_is_a_bow_between_the_ends_of_the_stroke():
    stage = StageSpec(straightness_mm=0.02, origin_mm=(0, 3, 4))
    places = coordinates(stage, np.array([0.0, 7, 14, 28]))
    assert places[:, 0] == pytest.approx([0, 7, 14, 28])
    assert places[:, 1] == pytest.approx([3, 3.015, 3.02, 3])
    assert places[:, 2] == pytest.approx(4)


def test_a_grid_goes_over_all_strokes():
    along, others = grid(StageSpec(origin_mm=(0, 0, 4)), (3, 2, 1))
    assert along.tolist() == [0, 14, 28]
    assert others.tolist() == [[0, 4], [22, 4]]


def test_axes_are_square_and_the_first_leads_out_of_the_needle():
    axes = StageSpec().axes((0.0, -1.0, 0.0))
    assert axes @ axes.T == pytest.approx(np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1)
    assert axes[0].tolist() == [0, 1, 0]
    assert axes[1].tolist() == [1, 0, 0]
    slanted = StageSpec(direction=(0, 0, 2), second_direction=(0, 1, 1)).axes((0, -1, 0))
    assert slanted[0].tolist() == [0, 0, 1]
    assert slanted[1] == pytest.approx([0, 1, 0])


def test_two_equal_directions_are_refused():
    with pytest.raises(InputError, match="first axis") as caught:
        StageSpec(direction=(1, 0, 0), second_direction=(-2, 0, 0)).axes((0, -1, 0))
    assert caught.value.field == "experiment.stage.second_direction"
