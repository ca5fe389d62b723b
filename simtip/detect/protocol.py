"""What simtip asks of a detector, wherever it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, Protocol, TypeAlias, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.detect.observation import TipObservation
from simtip.detect.parameters import DetectorParameters, Parameter

Image: TypeAlias = NDArray[np.uint8 | np.uint16]
"""(H, W) gray or (H, W, 3) RGB."""

P = TypeVar("P", bound=DetectorParameters)
P_contra = TypeVar("P_contra", bound=DetectorParameters, contravariant=True)


class ConfiguredDetector(Protocol):
    """A detector with its parameters chosen: an image in, an observation out."""

    def __call__(self, image: Image, *, layers: bool = False) -> TipObservation:
        """Look for the needle tip; with `layers`, keep the intermediate images.

        No tip is an observation with its reason, not an exception. The image is not changed.

        Raises
        ------
        InputError
            The array is no image of a supported kind.
        """
        ...


class Detector(Protocol):
    """A detector as the registry knows it; anything with this form will do.

    Nothing here says where it runs: a function of this package, of another package, or an
    external command can all take an image and named values and give a `TipObservation`.
    """

    @property
    def name(self) -> str:
        """Name by which it is chosen."""
        ...

    @property
    def summary(self) -> str:
        """One line for lists and help."""
        ...

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What can be set, with types, defaults and meanings."""
        ...

    def configure(self, values: Mapping[str, object]) -> ConfiguredDetector:
        """Check and convert the values, once; raise `InputError` for an unknown or bad one."""
        ...

    def __call__(self, image: Image, *, layers: bool = False, **values: object) -> TipObservation:
        """Configure and detect in one call."""
        ...


class DetectFunction(Protocol[P_contra]):
    """The working part of a detector written in Python."""

    def __call__(
        self, image: Image, parameters: P_contra, *, layers: bool = False
    ) -> TipObservation:
        """Look for the tip."""
        ...


@dataclass(frozen=True)
class ConfiguredFunction(Generic[P]):
    """A function with its parameters chosen: a `ConfiguredDetector`."""

    function: DetectFunction[P]
    parameters: P

    def __call__(self, image: Image, *, layers: bool = False) -> TipObservation:
        """Look for the needle tip."""
        return self.function(image, self.parameters, layers=layers)

    def for_camera(self, camera: Camera) -> ConfiguredDetector:
        """Give the detector for images of a known camera."""
        return ConfiguredFunction(self.function, self.parameters.for_camera(camera))

    def for_region(self, u0: int, v0: int, shape: tuple[int, ...]) -> ConfiguredDetector:
        """Give the detector for a region, which begins there, of images of a shape."""
        return ConfiguredFunction(self.function, self.parameters.for_region(u0, v0, shape))


def for_camera(detector: ConfiguredDetector, camera: Camera) -> ConfiguredDetector:
    """Tell a detector which camera took its images, if it wants to know.

    A detector wants to know if it has a method ``for_camera(camera)`` that gives a
    `ConfiguredDetector`; it is free to make no use of the camera.
    """
    return detector.for_camera(camera) if isinstance(detector, KnowsCameras) else detector


@runtime_checkable
class KnowsCameras(Protocol):
    """A configured detector that can make use of the camera's intrinsic parameters."""

    def for_camera(self, camera: Camera) -> ConfiguredDetector:
        """Give the detector for images of this camera."""
        ...


def for_region(
    detector: ConfiguredDetector, u0: int, v0: int, shape: tuple[int, ...]
) -> ConfiguredDetector:
    """Tell a detector that it sees a region of an image, if it wants to know.

    Parameters
    ----------
    detector
        Set up for the whole image.
    u0, v0
        First column and row of the region.
    shape
        Of the whole image.
    """
    return detector.for_region(u0, v0, shape) if isinstance(detector, KnowsRegions) else detector


@runtime_checkable
class KnowsRegions(Protocol):
    """A configured detector with parameters that are places in the image."""

    def for_region(self, u0: int, v0: int, shape: tuple[int, ...]) -> ConfiguredDetector:
        """Give the detector for a region of images of a shape."""
        ...


@dataclass(frozen=True)
class FunctionDetector(Generic[P]):
    """A `Detector` made of a Python function and the dataclass of its parameters.

    Attributes
    ----------
    name, summary
        As in `Detector`.
    parameters_type
        Declares the parameters.
    function
        ``function(image, parameters, layers=False)``.
    """

    name: str
    summary: str
    parameters_type: type[P]
    function: DetectFunction[P]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What can be set, with types, defaults and meanings."""
        return self.parameters_type.declared()

    def configure(self, values: Mapping[str, object]) -> ConfiguredDetector:
        """Check and convert the values; give the detector that uses them."""
        return ConfiguredFunction(self.function, self.parameters_type.from_mapping(values))

    def __call__(self, image: Image, *, layers: bool = False, **values: object) -> TipObservation:
        """Configure and detect in one call."""
        return self.configure(values)(image, layers=layers)
