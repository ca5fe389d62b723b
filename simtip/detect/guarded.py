"""A user's detector, held so that no fault of it ends a run or harms an image."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from simtip.detect.foreign_code import ForeignCodeError, foreign_code
from simtip.detect.gray import check_image
from simtip.detect.observation import TipObservation, TipStatus
from simtip.detect.outcome import observed
from simtip.detect.parameters import FIELD_PREFIX, Parameter
from simtip.detect.protocol import ConfiguredDetector, Image
from simtip.errors import InputError


@dataclass(frozen=True)
class GuardedDetector:
    """A `Detector` around one that others wrote.

    An exception becomes an observation with the status ``detector_error``; what is no observation,
    one with ``invalid_output`` (see `simtip.detect.outcome.observed`). The image is handed over as
    a read-only view: a detector that wants to write copies it first.

    Attributes
    ----------
    name, summary, parameters
        As in `Detector`.
    prepare
        Checks the values and gives the callable ``(image, layers=False)`` that may give anything.
    """

    name: str
    summary: str
    parameters: tuple[Parameter, ...]
    prepare: Callable[[Mapping[str, object]], Callable[..., object]]

    def configure(self, values: Mapping[str, object]) -> ConfiguredDetector:
        """Check and convert the values; raise `InputError` for one that does not fit."""
        try:
            with foreign_code():
                run = self.prepare(values)
        except ForeignCodeError as error:
            raise InputError(
                f"{self.name} cannot be set up: {error}",
                field=f"{FIELD_PREFIX}.name",
                remedy="mend the detector",
            ) from error

        def detect(image: Image, *, layers: bool = False) -> TipObservation:
            check_image(image)
            shown = image.view()
            shown.setflags(write=False)
            try:
                with foreign_code():
                    return observed(run(shown, layers=layers), image.shape)
            except ForeignCodeError as error:
                return TipObservation.failed(TipStatus.DETECTOR_ERROR, str(error))

        return detect

    def __call__(self, image: Image, *, layers: bool = False, **values: object) -> TipObservation:
        """Configure and detect in one call."""
        return self.configure(values)(image, layers=layers)
