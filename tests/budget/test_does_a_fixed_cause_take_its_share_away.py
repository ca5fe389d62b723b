"""Is the error of a system without a cause what the budget said that it would be?

The cause is mended in the scene itself, and the system tried anew, with other noise.
"""

from __future__ import annotations

import pytest
from experiment.small_experiment import asked, asked_as_users_do, scene_file


def row(told, kind, cause):
    return next(one for one in told[kind]["shares"] if one["cause"] == cause)


@pytest.mark.slow
def test_mended_play_of_the_needle_takes_its_share_away(tmp_path):
    told = asked("budget", scene_file(tmp_path, "loose.yaml", stage={"needle_play_mm": -0.5}))
    kind = "from_start"
    assert told[kind]["shares"][0]["cause"] == "stage and reference"
    tight = asked("budget", scene_file(tmp_path, "tight.yaml"), "--seed", 77)
    check(told, kind, "stage and reference", tight)


@pytest.mark.slow
def test_a_true_rig_takes_the_calibrations_share_away(tmp_path):
    bad = {"views": 10, "corner_noise_px": 0.1, "print_scale_error": 0.02}
    told = asked("budget", scene_file(tmp_path, "bad.yaml", calibration=bad), "--replicates", 8)
    kind = "position"
    assert told[kind]["shares"][0]["cause"] == "calibration"
    good = asked("budget", scene_file(tmp_path, "good.yaml"), "--seed", 77)
    check(told, kind, "calibration", good)


def check(told, kind, cause, mended):
    """Hold what goes with the cause, as claimed, against what went."""
    share = row(told, kind, cause)
    fell = told[kind]["total_mm2"] - mended[kind]["total_mm2"]
    low, high = share["removed_ci_mm2"]
    assert low <= fell <= high
    # The check can fail: the interval leaves out that nothing, or all, goes.
    assert low > 0
    assert share["removed_mm2"] < told[kind]["total_mm2"]


@pytest.mark.slow
def test_shares_add_up_to_the_total(tmp_path):
    told = asked_as_users_do("budget", scene_file(tmp_path))
    for kind in ("position", "step", "from_start"):
        one = told[kind]
        assert one["sum_of_shares_mm2"] + one["rest_mm2"] == pytest.approx(one["total_mm2"])
        assert one["rest_mm2"] < 1e-12
    assert told["position"]["shares"][0]["cause"] == "tip recession"
    assert told["recession_mm"]["mean"] == pytest.approx(0.76, abs=0.1)
    # The whole budget of what `mca` finds with the same places: a mean square of the same size.
    own = asked("mca", scene_file(tmp_path))
    assert told["position"]["rms_mm"] == pytest.approx(own["position"]["rms_mm"], rel=0.05)
