from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simtip.target import AsymmetricCircles, Charuco, Chessboard, CircleGrid, Target

TURNS = [np.linalg.matrix_power(np.array([[0, -1], [1, 0]]), k) for k in range(4)]
MIRROR = np.diag([-1, 1])


def looks_the_same(target: Target, change: np.ndarray) -> bool:
    """Whether the print and its points come upon themselves, turned or mirrored in the middle."""
    middle = (target.points[:, :2].min(axis=0) + target.points[:, :2].max(axis=0)) / 2
    half = (target.high - target.low) / 2 + 1
    x = np.random.default_rng(0).uniform(-half, half, (4000, 2))
    same_ink = (target.ink(x + middle) == target.ink(x @ change.T + middle)).mean()
    return bool(same_ink > 0.999)


def check(target: Target):
    assert target.half_turn_ambiguous == looks_the_same(target, TURNS[2])
    assert target.quarter_turn_ambiguous == looks_the_same(target, TURNS[1])
    # A mirror is undone by some turn, or it is not.
    assert target.chiral != any(looks_the_same(target, turn @ MIRROR) for turn in TURNS)


@given(st.integers(2, 7), st.integers(2, 7))
@settings(derandomize=True, deadline=None, max_examples=36)
def test_grids(columns: int, rows: int):
    check(Chessboard(columns, rows, 6.0))
    check(CircleGrid(columns, rows, 6.0, 3.0))
    check(AsymmetricCircles(columns, rows, 6.0, 3.0))


@pytest.mark.parametrize(("columns", "rows"), [(2, 4), (3, 6), (4, 8), (3, 3)])
def test_asymmetric_grids_in_a_square_box(columns: int, rows: int):
    check(AsymmetricCircles(columns, rows, 6.0, 3.0))


@pytest.mark.parametrize(("columns", "rows"), [(5, 5), (4, 4), (3, 6)])
def test_charuco(columns: int, rows: int):
    check(Charuco(columns, rows, 6.0, 4.5))
