"""Measurement capability: accuracy, agreement, repeatability, gauge R&R, registration.

Pure statistics of plain arrays; docs/capability.md has the definitions and their sources.
"""

from simtip.capability.accuracy import (
    Accuracy,
    ErrorSummary,
    assess_accuracy,
    displacement_errors,
    laser_displacements,
    summarise_errors,
    vision_displacements,
)
from simtip.capability.agreement import Agreement, assess_agreement
from simtip.capability.gauge import Gauge, assess_gauge
from simtip.capability.gauge_design import crossed
from simtip.capability.registration import Registration, register
from simtip.capability.repeatability import Repeatability, assess_repeatability

__all__ = [
    "Accuracy",
    "Agreement",
    "ErrorSummary",
    "Gauge",
    "Registration",
    "Repeatability",
    "assess_accuracy",
    "assess_agreement",
    "assess_gauge",
    "assess_repeatability",
    "crossed",
    "displacement_errors",
    "laser_displacements",
    "register",
    "summarise_errors",
    "vision_displacements",
]
