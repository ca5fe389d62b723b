"""Can an observation contradict itself?"""

import json

import numpy as np
import pytest

from simtip.detect import TipObservation, TipStatus


def test_a_tip_has_a_position_a_unit_axis_and_no_reason():
    o = TipObservation.found([3, 4.5], axis_px=[0, -7], covariance_px=[[1, 0.5], [0.5, 2]])
    assert o.ok
    assert o.status == "ok"
    assert o.reason == ""
    assert o.tip_px.dtype == np.float64
    assert o.tip_px.tolist() == [3, 4.5]
    assert o.axis_px.tolist() == [0, -1]
    assert o.covariance_px.shape == (2, 2)
    assert json.dumps(o.status) == '"ok"'


def test_a_failure_has_a_code_a_sentence_and_nothing_else():
    o = TipObservation.failed(TipStatus.NO_EDGE, "Canny finds no edge")
    assert not o.ok
    assert (o.status, o.reason) == ("no_edge", "Canny finds no edge")
    assert o.tip_px is o.axis_px is o.covariance_px is None


def test_what_was_given_can_neither_change_it_nor_be_changed_by_it():
    tip = np.array([1.0, 2.0])
    o = TipObservation.found(tip)
    tip[0] = 9
    assert o.tip_px[0] == 1
    with pytest.raises(ValueError, match="read-only"):
        o.tip_px[0] = 5


@pytest.mark.parametrize(
    "build",
    [
        lambda: TipObservation.failed(TipStatus.OK, "fine"),
        lambda: TipObservation.failed(TipStatus.NO_EDGE, ""),
        lambda: TipObservation(TipStatus.OK),
        lambda: TipObservation(TipStatus.OK, "why", tip_px=np.zeros(2)),
        lambda: TipObservation(TipStatus.NO_EDGE, "why", tip_px=np.zeros(2)),
        lambda: TipObservation(TipStatus.NO_EDGE, "why", axis_px=np.array([0.0, 1.0])),
        lambda: TipObservation("lost", "why"),
        lambda: TipObservation.found([1, np.nan]),
        lambda: TipObservation.found([1, 2, 3]),
        lambda: TipObservation.found([1, 2], axis_px=[0, 0]),
        lambda: TipObservation.found([1, 2], axis_px=[0, 0, 1]),
        lambda: TipObservation.found([1, 2], covariance_px=[[1, 2], [2, 1]]),
        lambda: TipObservation.found([1, 2], covariance_px=[[1, 0], [1, 1]]),
        lambda: TipObservation.found([1, 2], covariance_px=np.eye(3)),
    ],
)
def test_a_contradiction_cannot_be_built(build):
    with pytest.raises(ValueError):  # noqa: PT011 - each has its own message
        build()
