"""All pictures of a calibration."""

from __future__ import annotations

from simtip.calibration_images import Outcome
from simtip.report.coverage import plot_coverage
from simtip.report.epipolar import plot_epipolar
from simtip.report.error_map import plot_error_map
from simtip.report.reprojection import plot_reprojection


def calibration_plots(outcome: Outcome) -> dict[str, bytes]:
    """Draw them as PNG files, by name; the error map only where the truth is known."""
    calibration = outcome.calibration
    plots = {
        "reprojection.png": plot_reprojection(calibration),
        "epipolar.png": plot_epipolar(calibration),
        "coverage.png": plot_coverage(calibration),
    }
    if outcome.judgement is not None:
        plots["error_map.png"] = plot_error_map(outcome.judgement.error_map)
    return plots
