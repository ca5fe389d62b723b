"""What an experiment says of the measuring system: the figures, and how they are told."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from simtip.capability import (
    Accuracy,
    Agreement,
    ErrorSummary,
    Gauge,
    Registration,
    Repeatability,
)
from simtip.capability.interval import ends
from simtip.errors import InputError
from simtip.experiment.performed import Measured
from simtip.geometry import Array
from simtip.spec.experiment import ExperimentSpec
from simtip.sweep.table import OK

CAMERA, STAGE = "camera", "stage"
"""Frames in which positions are told."""


@dataclass(frozen=True, eq=False)
class Displacements:
    """Measured and reference displacements that are there, mm, each (n,).

    Attributes
    ----------
    measured, reference
        By the cameras (Eq. 1) and by the interferometer (Eq. 2).
    run, position
        (n,) of each.
    """

    measured: Array
    reference: Array
    run: tuple[int, ...]
    position: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Position:
    """How far measured positions are from the true ones, which only a simulation knows.

    Attributes
    ----------
    frame
        In which they are told: "camera", the world's; or "stage", as registered.
    axes
        Of x, y, z in that frame, signed; of each position the mean of its runs.
    rms_mm, max_mm
        Of the distance.
    """

    frame: str
    axes: Mapping[str, ErrorSummary]
    rms_mm: float
    max_mm: float

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        axes = {name: summary.to_dict() for name, summary in self.axes.items()}
        return {"frame": self.frame, "rms_mm": self.rms_mm, "max_mm": self.max_mm, **axes}


@dataclass(frozen=True, eq=False)
class Frame:
    """The stage's frame as it was found, and how far off it is.

    Attributes
    ----------
    registration
        ``stage = R world + t`` over the registration's places.
    rotation_error_deg
        Angle between it and the true one.
    position
        Of the first set-up's tips in that frame, against where the needle was.
    mean_xyz_mm
        (3,) mean of their errors.
    """

    registration: Registration
    rotation_error_deg: float
    position: Position
    mean_xyz_mm: Array

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        return {
            **self.registration.to_dict(),
            "rotation_error_deg": self.rotation_error_deg,
            "position_error_mm": {
                "rms": self.position.rms_mm,
                "max": self.position.max_mm,
                "mean_xyz": self.mean_xyz_mm.tolist(),
            },
        }


@dataclass(frozen=True, eq=False)
class Capability:
    """Everything that an experiment allows; what is None is in `left_out`, with the reason.

    Attributes
    ----------
    spec
        The experiment.
    measured
        What was measured, by series.
    steps, from_start
        Displacements of the first set-up: from one position to the next, of the runs that count for
        accuracy; and from a run's start, of all.
    accuracy
        Of steps: Eq. 1 to 3. None if fewer than two were measured.
    accuracy_from_start
        The same of displacements from a run's start, of all runs.
    agreement, agreement_repeated
        Of displacements from a run's start; each as a subject of its own, and as repeated
        measurements of the positions, whose true value varies.
    repeatability, repeatability_of_errors
        Of measured displacements, and of measured minus reference.
    grr
        Of positions along the first axis: parts are places, operators set-ups.
    position
        Against the truth.
    frame
        Of the stage.
    left_out, notes
        Why a result is missing, by its name; what a reader has to know.
    """

    spec: ExperimentSpec
    measured: Sequence[Measured]
    steps: Displacements
    from_start: Displacements
    accuracy: Accuracy | None
    accuracy_from_start: Accuracy
    agreement: Agreement
    agreement_repeated: Agreement | None
    repeatability: Repeatability | None
    repeatability_of_errors: Repeatability | None
    grr: Gauge | None
    position: Position
    frame: Frame | None
    left_out: Mapping[str, str]
    notes: tuple[str, ...]

    def to_dict(self, frame: str = CAMERA) -> dict[str, Any]:
        """Give plain values for JSON.

        Parameters
        ----------
        frame
            In which positions are told: "camera", or "stage" as it was registered.

        Raises
        ------
        InputError
            No frame of the stage was found.
        """
        if frame == STAGE and self.frame is None:
            raise InputError(
                f"the stage's frame is unknown: {self.left_out['registration']}",
                field="--frame",
                remedy="add experiment.schedule.registration, or leave --frame out",
            )
        position = self.position if frame == CAMERA or self.frame is None else self.frame.position
        agreement = self.agreement.to_dict()
        agreement["repeated"] = _plain(self.agreement_repeated)
        repeatability = _plain(self.repeatability)
        if repeatability is not None:
            repeatability["of_errors"] = _plain(self.repeatability_of_errors)
        return {
            "level": self.spec.level,
            "detection": self._detection(),
            "accuracy": self._accuracy(),
            "agreement": agreement,
            "repeatability": repeatability,
            "grr": _plain(self.grr),
            "position": position.to_dict(),
            "registration": _plain(self.frame),
            "left_out": dict(self.left_out),
            "notes": list(self.notes),
        }

    def _accuracy(self) -> dict[str, Any] | None:
        if self.accuracy is None:
            return None
        start = self.accuracy_from_start.to_dict()
        # These would take displacements as independent.
        start |= dict.fromkeys(("mean_abs_ci_mm", "rms_ci_mm"))
        start["mean_ci_mm"] = ends(self.agreement.limits.bias_ci)
        told = {**self.accuracy.to_dict(), "from_start": start}
        for part in (told, start):
            if part["linearity"] is not None:
                part["linearity"] |= dict.fromkeys(("intercept_ci_mm", "intercept_p"))
        return told

    def _detection(self) -> dict[str, Any]:
        status = Counter(str(one) for part in self.measured for one in part.status.ravel())
        total = sum(status.values())
        failed = {name: count for name, count in sorted(status.items()) if name != OK}
        return {"measurements": total, "rate": status[OK] / total, "failed": failed}


def _plain(result: Any) -> Any:
    return None if result is None else result.to_dict()
