"""All pictures of a calibration."""

from __future__ import annotations

from matplotlib.figure import Figure

from simtip.calibration_images.record import Record
from simtip.report.coverage import coverage_figure
from simtip.report.epipolar import epipolar_figure
from simtip.report.error_map import error_map_figure
from simtip.report.reprojection import reprojection_figure


def calibration_figures(calibration: Record) -> dict[str, Figure]:
    """Draw them, by name; the error map only where the truth is known."""
    figures = {
        "reprojection": reprojection_figure(calibration),
        "epipolar": epipolar_figure(calibration),
        "coverage": coverage_figure(calibration),
    }
    if calibration.error_map is not None:
        figures["error_map"] = error_map_figure(calibration.error_map)
    return figures
