"""Against errors put in by hand, without pytest's machinery."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest

from simtip.camera import Camera
from simtip.detect import TipObservation, TipStatus
from simtip.errors import InputError
from simtip.measure import Measurement
from simtip.pytest_plugin.limits import Limits
from simtip.score import score_tip

TRUE_LEFT, TRUE_RIGHT = np.array([50.0, 80.0]), np.array([60.0, 70.0])
UP = np.array([0.0, -1.0])


def measured(left=(0.0, 0.0), right=(0.0, 0.0), mm=(0.0, 0.0, 0.0), *, width=100):
    """Give a measurement with these errors, px and mm; None is no tip."""
    K = np.array([[100.0, 0, 50], [0, 100.0, 50], [0, 0, 1]])
    seen = [
        TipObservation.failed(TipStatus.NOT_FOUND, "it is too dark")
        if error is None
        else TipObservation.found(true + error)
        for error, true in zip((left, right), (TRUE_LEFT, TRUE_RIGHT), strict=True)
    ]
    error = score_tip(
        point_measured_mm=mm,
        point_true_mm=None if mm is None else (0.0, 0.0, 0.0),
        tips_measured_px=(seen[0].tip_px, seen[1].tip_px),
        tips_true_px=(TRUE_LEFT, TRUE_RIGHT),
        axes_true_px=(UP, UP),
    )
    views = [SimpleNamespace(tip_px=true) for true in (TRUE_LEFT, TRUE_RIGHT)]
    rig = SimpleNamespace(left=Camera(K, 100, 100), right=Camera(K, width, 100))
    truth = SimpleNamespace(left=views[0], right=views[1], rig=rig)
    pair = SimpleNamespace(truth=truth, tip_in_images=width > 60)
    return SimpleNamespace(pair=pair, measurement=Measurement(*seen), error=error)


@pytest.mark.parametrize(
    ("limits", "errors", "sides"),
    [
        ({"px": 5.0}, {"left": (3.0, 4.0)}, []),
        ({"px": 4.99}, {"left": (3.0, 4.0)}, ["left"]),
        ({"px": 1.0}, {"left": (3.0, 4.0), "right": (0.0, -2.0)}, ["left", "right"]),
        ({"along_px": 2.0}, {"left": (9.0, 2.0), "right": (9.0, -2.0)}, []),
        ({"along_px": 1.99}, {"left": (0.0, 2.0), "right": (0.0, -2.0)}, ["left", "right"]),
        ({"across_px": 2.0}, {"left": (2.0, 9.0), "right": (-2.0, -9.0)}, []),
        ({"across_px": 1.99}, {"left": (2.0, 0.0), "right": (-2.0, 0.0)}, ["left", "right"]),
        ({"mm": 3.0}, {"left": (30.0, 0.0), "mm": (1.0, 2.0, 2.0)}, []),
        ({"mm": 2.99}, {"mm": (1.0, 2.0, 2.0)}, ["in space"]),
        ({"px": 1.0, "mm": 1.0}, {"left": (2.0, 0.0), "mm": (0, 0, -2)}, ["left", "in space"]),
        ({"mm": 1.0}, {"mm": None}, ["in space"]),
        ({"px": 1.0}, {"mm": None}, []),
        ({"px": 1.0}, {"left": None}, ["left"]),
        ({"mm": 1.0}, {"left": None, "right": None, "mm": None}, ["left", "right"]),
        ({"px": 0.0, "along_px": 0.0, "across_px": 0.0, "mm": 0.0}, {}, []),
    ],
)
def test_a_complaint_comes_just_beyond_the_limit(limits, errors, sides):
    said = Limits(**limits).complaints(measured(**errors))
    assert [line.partition(":")[0] for line in said] == sides


def test_where_the_true_tip_is_outside_no_tip_may_be_found():
    limits = Limits(px=1.0, mm=0.1)
    outside = measured(right=None, mm=None, width=50)
    assert limits.complaints(outside) == []
    (said,) = limits.complaints(measured(right=(0.0, 0.0), mm=(9.0, 9.0, 9.0), width=50))
    assert (
        said
        == "right: a tip found at (60.0, 70.0); the true one, (60.0, 70.0), is outside the image"
    )
    (said,) = limits.complaints(measured(left=(5.0, 0.0), right=None, mm=None, width=50))
    assert said.startswith("left: 5.00 px off")


def test_a_complaint_says_by_how_much_and_where():
    """The axis points up, so an error downwards is beyond the tip: along is -v, across is +u."""
    errors = {"left": (3.0, 4.0), "right": (-0.5, -6.0), "mm": (1.0, -2.0, 2.0)}
    left, right, space = Limits(px=1.0, mm=1.0).complaints(measured(**errors))
    assert left == (
        "left: 5.00 px off, along -4.00 (beyond the tip), across +3.00; "
        "found at (53.0, 84.0), truly at (50.0, 80.0)"
    )
    assert re.search(
        r"along \+6.00 \(short of the tip\), across -0.50; found at \(59.5, 64.0\)", right
    )
    assert space == "in space: 3.000 mm off, x +1.000, y -2.000, z +2.000"
    (lost,) = Limits(px=1.0).complaints(measured(left=None))
    assert lost == "left: no tip found (it is too dark); it is at (50.0, 80.0)"


def test_limits_are_said_as_given():
    assert str(Limits(px=2.0, along_px=1.5, across_px=0.25, mm=0.1)) == (
        "2 px, 1.5 px along, 0.25 px across, 0.1 mm"
    )


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({}, "the assertion has no limit; give px=, along_px=, across_px= or mm="),
        ({"px": -1.0}, "px: is -1.0; give a number from 0 on"),
        ({"mm": float("nan")}, "mm: is nan; give a number from 0 on"),
        ({"px": float("inf")}, "px: is inf; give a number from 0 on"),
        ({"px": "2"}, "px: is '2'; give a number from 0 on"),
        ({"px": True}, "px: is True; give a number from 0 on"),
    ],
)
def test_limits_that_are_none_are_refused(wrong, said):
    with pytest.raises(InputError, match=f"^{re.escape(said)}$"):
        Limits(**wrong)
