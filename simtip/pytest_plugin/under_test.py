"""The detector that a test names or hands over."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import cast

from simtip.detect import ConfiguredDetector, Image, TipObservation
from simtip.detect.adopted import adopted
from simtip.detect.gray import check_image
from simtip.detect.outcome import observed
from simtip.detect.protocol import KnowsCameras
from simtip.errors import InputError
from simtip.spec import SceneSpec
from simtip.trial import detector_of, with_detector

PACKAGE = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class DetectorUnderTest:
    """A detector whose exceptions are the test's own: they reach it as they were raised.

    Attributes
    ----------
    run
        Called with the image, read-only; it may give what `simtip.detect.outcome.observed` takes.
    """

    run: Callable[..., object]

    def __call__(self, image: Image, *, layers: bool = False) -> TipObservation:
        """Look for the needle tip."""
        check_image(image)
        return observed(self.run(image, layers=layers), image.shape)


def under_test(
    detector: object, settings: Mapping[str, object], spec: SceneSpec
) -> ConfiguredDetector:
    """Set up a detector for a scene's images.

    Parameters
    ----------
    detector
        A function of the image, or an object with the protocol `simtip.detect.Detector`, or a
        configured one; or what names one, see `simtip.detect.get`, also a program or a module; or
        None, the scene's own.
    settings
        Its parameters.
    spec
        The scene.

    Raises
    ------
    InputError
        There is no such detector or parameter, or a value does not fit.
    """
    if detector is None or isinstance(detector, str):
        return detector_of(with_detector(spec, detector, settings), allowed=detector)
    if isinstance(detector, KnowsCameras):
        if settings:
            raise InputError(
                f"is set already, and takes no {next(iter(settings))}",
                field="detect",
                remedy="configure it with that",
            )
        return cast("ConfiguredDetector", detector)
    name = getattr(detector, "__name__", type(detector).__name__)
    run: object = adopted(str(name), detector).prepare(settings)
    if isinstance(run, KnowsCameras):
        return cast("ConfiguredDetector", run)
    return DetectorUnderTest(cast("Callable[..., object]", run))


def beyond_simtip(trace: TracebackType | None) -> TracebackType | None:
    """Give the part of a traceback that begins in the test's own code; None if there is none."""
    while trace is not None and _is_own(trace.tb_frame.f_code.co_filename):
        trace = trace.tb_next
    return trace


def _is_own(file: str) -> bool:
    return Path(file).is_relative_to(PACKAGE)
