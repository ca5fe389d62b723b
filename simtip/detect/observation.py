"""What a detector says about one image: a tip, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array, unit

Layers: TypeAlias = Mapping[str, NDArray[Any]]


class TipStatus(StrEnum):
    """Machine-readable outcome of a detection; each value is also its text in results."""

    OK = "ok"
    NOTHING_DARKER_THAN_THRESHOLD = "nothing_darker_than_threshold"
    EVERYTHING_DARKER_THAN_THRESHOLD = "everything_darker_than_threshold"
    NO_COMPONENT_LARGE_ENOUGH = "no_component_large_enough"
    NO_EDGE = "no_edge"
    TOUCHES_BORDER = "touches_border"
    NOT_FOUND = "not_found"
    """A user's detector looked, and says that there is no tip."""
    DETECTOR_ERROR = "detector_error"
    """A user's detector raised an exception."""
    COMMAND_FAILED = "command_failed"
    """An external command did not start, ended with an exit code, or was killed by a signal."""
    COMMAND_TIMED_OUT = "command_timed_out"
    """An external command was stopped at its time limit."""
    INVALID_OUTPUT = "invalid_output"
    """What a user's detector gave is no observation: garbage, NaN, a wrong shape, silence."""


@dataclass(frozen=True, eq=False)
class TipObservation:
    """A needle tip seen in one image, or why none was found.

    Build one with `found` or `failed`. A tip without an "ok", or an "ok" without a tip, cannot
    be built by any way.

    Attributes
    ----------
    status
        ``ok``, or the code of the reason.
    reason
        One sentence with the numbers; empty when the tip was found.
    tip_px
        (2,) u, v in px of the image as given (not undistorted), or None.
    axis_px
        (2,) unit direction from the tip towards the hub, in the image, or None if unknown.
    covariance_px
        (2, 2) px^2 of `tip_px` as the detector claims it, or None if it claims none.
    confidence
        0 to 1, by the detector's own measure, or None if it has none.
    layers
        Intermediate images by name, for overlays; empty unless asked for.
    """

    status: TipStatus
    reason: str = ""
    tip_px: Array | None = None
    axis_px: Array | None = None
    covariance_px: Array | None = None
    confidence: float | None = None
    layers: Layers = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "status", TipStatus(self.status))
        if self.ok:
            self._check_found()
        elif not self.reason:
            raise ValueError("a failure needs its reason")
        elif any(
            part is not None
            for part in (self.tip_px, self.axis_px, self.covariance_px, self.confidence)
        ):
            raise ValueError("a failure has no tip, no axis, no covariance and no confidence")

    def _check_found(self) -> None:
        if self.reason:
            raise ValueError("a tip that was found has no reason for failure")
        if self.tip_px is None:
            raise ValueError("a tip that was found has a position")
        object.__setattr__(self, "tip_px", _frozen(self.tip_px, (2,), "a tip position"))
        if self.axis_px is not None:
            object.__setattr__(self, "axis_px", _frozen(unit(self.axis_px), (2,), "an axis"))
        if self.covariance_px is not None:
            covariance = _frozen(self.covariance_px, (2, 2), "a tip covariance")
            # A line is a covariance, too: its second eigenvalue is 0, to rounding.
            least = -1e-9 * abs(np.trace(covariance))
            symmetric = np.allclose(covariance, covariance.T, atol=abs(least))
            if not symmetric or np.linalg.eigvalsh(covariance)[0] < least:
                raise ValueError("a covariance is symmetric with no negative eigenvalue")
            object.__setattr__(self, "covariance_px", covariance)
        if self.confidence is not None:
            if not 0 <= self.confidence <= 1:
                raise ValueError(f"a confidence lies between 0 and 1, not at {self.confidence:g}")
            object.__setattr__(self, "confidence", float(self.confidence))

    @classmethod
    def found(
        cls,
        tip_px: ArrayLike,
        *,
        axis_px: ArrayLike | None = None,
        covariance_px: ArrayLike | None = None,
        confidence: float | None = None,
        layers: Layers | None = None,
    ) -> TipObservation:
        """Report a tip.

        Parameters
        ----------
        tip_px
            (2,) u, v, px.
        axis_px
            (2,) direction from the tip towards the hub, of any length, or None.
        covariance_px
            (2, 2) px^2, or None.
        confidence
            0 to 1, or None.
        layers
            Intermediate images by name.

        Raises
        ------
        ValueError
            A number is not finite or out of its range, or an array has another shape.
        """
        return cls(
            TipStatus.OK,
            tip_px=np.asarray(tip_px, dtype=np.float64),
            axis_px=None if axis_px is None else np.asarray(axis_px, dtype=np.float64),
            covariance_px=(
                None if covariance_px is None else np.asarray(covariance_px, dtype=np.float64)
            ),
            confidence=confidence,
            layers=layers or {},
        )

    @classmethod
    def failed(
        cls, status: TipStatus, reason: str, *, layers: Layers | None = None
    ) -> TipObservation:
        """Report that there is no tip: a code other than ``ok``, and one sentence with the numbers.

        Raises
        ------
        ValueError
            The status is ``ok``, or the reason is empty.
        """
        return cls(status, reason, layers=layers or {})

    @property
    def ok(self) -> bool:
        """Whether a tip was found."""
        return self.status is TipStatus.OK


def _frozen(values: Array, shape: tuple[int, ...], what: str) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"{what} is {' x '.join(map(str, shape))} finite numbers")
    array.setflags(write=False)
    return array
