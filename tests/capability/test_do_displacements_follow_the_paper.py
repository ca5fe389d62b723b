"""Are displacements and steps those of Eq. 1 to 3, run by run?"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from simtip.capability import displacement_errors, laser_displacements, vision_displacements
from simtip.capability.motion import motion

POINTS = [(0.0, 0.0, 170.0), (2.0, 0.0, 170.0), (4.0, 0.1, 170.2), (3.0, 0.1, 170.2)]
READINGS = [10.0, 12.0, 14.0, 13.0]


def test_distances_are_euclidean_and_the_lasers_absolute():
    found = vision_displacements(POINTS)
    expected = [math.dist(a, b) for a, b in itertools.pairwise(POINTS)]
    assert found.tolist() == pytest.approx(expected, abs=1e-12)
    assert laser_displacements(READINGS).tolist() == [2, 2, 1]
    errors = displacement_errors(found, laser_displacements(READINGS))
    assert errors.tolist() == pytest.approx(
        [e - d for e, d in zip(expected, [2, 2, 1], strict=True)]
    )


def test_points_need_three_finite_coordinates():
    with pytest.raises(ValueError, match=r"positions \(n, 3\)"):
        vision_displacements([(0, 0), (1, 1)])
    with pytest.raises(ValueError, match="finite"):
        vision_displacements([(0, 0, math.nan), (1, 1, 1)])
    with pytest.raises(ValueError, match="do not pair"):
        displacement_errors([1.0, 2.0], [1.0])


def lists(found):
    return [part.tolist() for part in (found.measured, found.reference, *found.steps)]


def test_a_displacements_first_step_begins_at_0_in_each_run():
    found = motion([2.5, 4.25, 2.125, 4.5], [2, 4, 2, 4.0], [1, 1, 2, 2])
    assert lists(found)[:2] == [[2.5, 4.25, 2.125, 4.5], [2, 4, 2, 4]]
    assert lists(found)[2:] == [[2.5, 1.75, 2.125, 2.375], [2, 2, 2, 2]]
    # Where the start is a row of its own, it is not put in once more.
    found = motion([0.5, 2.5], [0, 2.0], [1, 1])
    assert lists(found)[2:] == [[2], [2]]


def test_runs_may_be_interleaved_and_rows_stay_in_their_places():
    found = motion([2.5, 2.125, 4.25, 4.5], [2, 2, 4, 4.0], ["a", "b", "a", "b"])
    assert found.rows.tolist() == [0, 1, 2, 3]
    assert found.measured.tolist() == [2.5, 2.125, 4.25, 4.5]
    assert found.steps[0].tolist() == [2.5, 1.75, 2.125, 2.375]


def test_positions_count_from_the_first_of_their_run():
    found = motion([7, 9.5, 5, 1, 3.0], [10, 12, 8, 50, 52.0], [1, 1, 1, 2, 2], "position")
    assert found.rows.tolist() == [1, 2, 4]
    assert lists(found) == [[2.5, 2, 2], [2, 2, 2], [2.5, 4.5, 2], [2, 4, 2]]


def test_steps_are_added_up_run_by_run():
    found = motion([2, 2.5, 1.5], [2, 2, 2.0], [1, 1, 2], "step")
    assert lists(found) == [[2, 2.5, 1.5], [2, 2, 2], [2, 2.5, 1.5], [2, 2, 2]]
    assert [part.tolist() for part in found.cumulative] == [[2, 4.5, 1.5], [2, 4, 2]]
    assert np.all(found.rows == [0, 1, 2])
