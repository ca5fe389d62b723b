"""A detector asked about pictures, with all that has to hold of every answer checked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.detect.observation import TipObservation, TipStatus
from simtip.detect.protocol import ConfiguredDetector, Image
from simtip.errors import InputError

NEAR_PX = 32.0
"""A tip may lie this far outside the picture: a cut-off needle can be continued."""

FAULTS = frozenset(
    {
        TipStatus.DETECTOR_ERROR,
        TipStatus.INVALID_OUTPUT,
        TipStatus.COMMAND_FAILED,
        TipStatus.COMMAND_TIMED_OUT,
    }
)
"""Statuses that stand for a detector's own fault, not for what is in the picture."""


class FaultError(Exception):
    """An answer, or the lack of one, that no picture excuses; the text says what it was."""


class Probe:
    """Asks a detector, and remembers whether it ever changed an image.

    Parameters
    ----------
    detector
        The detector.
    before
        Called before each question.
    """

    def __init__(self, detector: ConfiguredDetector, before: Callable[[], None]) -> None:
        self._detector, self._before = detector, before
        self.asked = 0
        self.changed: list[str] = []

    def see(self, image: Image) -> TipObservation:
        """Ask about one image.

        Raises
        ------
        FaultError
            There was an exception, or the answer is no observation of this image.
        """
        self._before()
        self.asked += 1
        before = image.copy()
        try:
            seen = self._detector(image)
        except Exception as error:  # whatever a detector may raise is what is looked for
            raise FaultError(_said(error, image)) from error
        if not np.array_equal(image, before):
            self.changed.append(_form(image))
            if image.flags.writeable:
                image[...] = before
        check_answer(seen, image)
        return seen

    def refuses(self, array: NDArray[Any]) -> bool:
        """Say whether an array that is no image is refused by `InputError`, as it should be.

        Raises
        ------
        FaultError
            There was another exception.
        """
        self._before()
        try:
            self._detector(array)
        except InputError:
            return True
        except Exception as error:  # as above
            raise FaultError(f"{type(error).__name__} on what is no image") from error
        return False


def check_answer(seen: object, image: Image) -> None:
    """Raise `FaultError` unless this is an observation that may be true of such an image."""
    where = _form(image)
    if not isinstance(seen, TipObservation):
        raise FaultError(f"it gives {type(seen).__name__}, not a TipObservation, on {where}")
    if seen.status in FAULTS:
        raise FaultError(f"{seen.status} on {where}: {seen.reason}")
    if seen.tip_px is None:
        return
    size = np.array(image.shape[1::-1])
    if (seen.tip_px < -NEAR_PX).any() or (seen.tip_px > size + NEAR_PX).any():
        raise FaultError(f"it claims a tip at {said_point(seen.tip_px)}, outside {where}")


def said_point(point_px: object) -> str:
    """Give a point in words."""
    u, v = np.asarray(point_px, dtype=np.float64)
    return f"({u:.1f}, {v:.1f})"


def _said(error: Exception, image: Image) -> str:
    text = " ".join(str(error).split())[:120]
    return f"{type(error).__name__} on {_form(image)}: {text}"


def _form(image: Image) -> str:
    colour = " colour" if image.ndim == 3 else ""
    return f"{image.shape[1]} x {image.shape[0]} px{colour} of {image.dtype.itemsize * 8} bits"
