"""From image files of a calibration target to a calibrated rig, and to what it is worth.

`find_pairs` says which files belong together, `look_at` finds the target in them, and
`calibrate_images` does it all; with the truth that `simtip boards` writes, errors, too.
"""

from __future__ import annotations

from simtip.calibration_images.board_truth import BoardTruth, read_board_truth
from simtip.calibration_images.corner_error import CornerError, corner_error
from simtip.calibration_images.look import Looked, look_at
from simtip.calibration_images.outcome import Outcome, calibrate_images
from simtip.calibration_images.pairs import Pair, Pairs, find_pairs

__all__ = [
    "BoardTruth",
    "CornerError",
    "Looked",
    "Outcome",
    "Pair",
    "Pairs",
    "calibrate_images",
    "corner_error",
    "find_pairs",
    "look_at",
    "read_board_truth",
]
