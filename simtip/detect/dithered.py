"""A detector without its pixels: the mean of another one over images moved by parts of a pixel.

Subtractive dither (Schuchman, "Dither signals and their effect on quantization noise", IEEE Trans.
Commun. Technol. 12, 162-165, 1964; Gray and Stockham, "Dithered quantizers", IEEE Trans. Inf.
Theory 39, 805-812, 1993): a known shift is added before what rounds, and subtracted after it. Over
shifts that fill a pixel evenly the mean has no rounding left. For a detector that answers on whole
pixels that is its answer with a grid of pixels that is infinitely fine, while the area that a pixel
gathers light from, noise, filters' windows and thresholds stay as they are. A detector with answers
between pixels gives what it gave, but for rounding of the moved images and for edges sharper than
pixels can show.

It tells how much of a detector's error its pixels are; it is as slow as so many detections are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from simtip.camera import Camera
from simtip.detect.gray import to_gray
from simtip.detect.lin2020_parameters import Lin2020Parameters
from simtip.detect.observation import TipObservation, TipStatus
from simtip.detect.parameters import (
    FIELD_PREFIX,
    Declaration,
    Declared,
    Parameter,
    check_names,
    values_of,
)
from simtip.detect.protocol import ConfiguredDetector, Detector, Image, for_camera, for_region
from simtip.detect.shifted import shifted
from simtip.errors import InputError
from simtip.geometry import Array

PREFIX = "dithered:"
FIELD = f"{FIELD_PREFIX}.name"

STEPS = Declaration(
    "dither_steps",
    int,
    4,
    Declared(
        "the image is moved to so many times so many places within a pixel; 1 moves nothing",
        minimum=1,
        maximum=8,
    ),
)
"""The parameter that every dithered detector has beside those of the other."""

ENOUGH = 0.75
"""Part of the moved images in which the tip has to be found."""
SAME_PX = 20.0
"""A tip farther than this from that in the image as it is belongs to something else."""


@dataclass(frozen=True)
class DitheredDetector:
    """A `Detector` that is another one without the rounding to pixels.

    Attributes
    ----------
    name
        By which it is chosen.
    inner
        The other.
    """

    name: str
    inner: Detector

    @property
    def summary(self) -> str:
        """One line for lists and help."""
        return f"without its rounding to pixels: {self.inner.summary}"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What can be set: the other's parameters, and the number of shifts."""
        return (*self.inner.parameters, STEPS.parameter)

    def configure(self, values: Mapping[str, object]) -> ConfiguredDetector:
        """Check and convert the values; raise `InputError` for an unknown or bad one."""
        check_names(values, [parameter.name for parameter in self.parameters])
        inner = {name: value for name, value in values.items() if name != STEPS.name}
        own = {name: value for name, value in values.items() if name == STEPS.name}
        return ConfiguredDither(self.inner.configure(inner), **values_of([STEPS], own))

    def __call__(self, image: Image, *, layers: bool = False, **values: object) -> TipObservation:
        """Configure and detect in one call."""
        return self.configure(values)(image, layers=layers)


@dataclass(frozen=True)
class ConfiguredDither:
    """A detector with its parameters chosen, and how finely the image is moved.

    Attributes
    ----------
    inner
        The detector.
    dither_steps
        Shifts along each side of a pixel, K: see `shifts_px`.
    """

    inner: ConfiguredDetector
    dither_steps: int

    def __call__(self, image: Image, *, layers: bool = False) -> TipObservation:
        """Look for the tip in the image as it is, and then in it moved.

        Tip and axis are means over the moved images. Covariance, confidence and layers are those of
        the image as it is; so is a failure in it. Of the moved ones `ENOUGH` have to show a tip.
        """
        first = self.inner(image, layers=layers)
        if not first.ok or self.dither_steps == 1:
            return first
        shifts = shifts_px(self.dither_steps)
        moved = zip(shifts, shifted(_all_it_uses(self.inner, image), shifts), strict=True)
        return _mean(first, [_moved_back(self.inner(one), shift) for shift, one in moved])

    def for_camera(self, camera: Camera) -> ConfiguredDetector:
        """Tell the detector its camera, whose principal point is not moved by parts of a pixel."""
        return replace(self, inner=for_camera(self.inner, camera))

    def for_region(self, u0: int, v0: int, shape: tuple[int, ...]) -> ConfiguredDetector:
        """Tell the detector that it sees a region, which begins there, of images of a shape."""
        return replace(self, inner=for_region(self.inner, u0, v0, shape))


def _all_it_uses(inner: ConfiguredDetector, image: Image) -> Image:
    """Give an image with all that a detector uses of it: of three colours, one gray to move."""
    parameters = getattr(inner, "parameters", None)
    if isinstance(parameters, Lin2020Parameters) and image.ndim == 3 and image.dtype == np.uint8:
        return to_gray(image, parameters.weights)
    return image


def undithered(reference: str) -> str:
    """Give the reference after the prefix.

    Raises
    ------
    InputError
        There is none, or it is dithered itself.
    """
    inner = reference.removeprefix(PREFIX)
    if not inner:
        raise InputError(
            f"there is no detector after {PREFIX}", field=FIELD, remedy=f"write {PREFIX}lin2020"
        )
    if inner.startswith(PREFIX):
        raise InputError(
            f"{reference!r} is dithered twice", field=FIELD, remedy=f"write {PREFIX} once"
        )
    return inner


def dithered_detector(reference: str, inner: Detector) -> DitheredDetector:
    """Make the detector without pixels of another.

    Raises
    ------
    InputError
        The other has a parameter of the same name as that for the shifts.
    """
    if STEPS.name in {parameter.name for parameter in inner.parameters}:
        raise InputError(
            f"{inner.name} has a parameter {STEPS.name!r} itself",
            field=FIELD,
            remedy="call that otherwise",
        )
    return DitheredDetector(reference, inner)


def shifts_px(steps: int) -> Array:
    """Give shifts that fill a pixel evenly, (K^2, 2) u, v, px, within half a pixel, their sum 0.

    One lies in each of K x K cells, and one in each of K^2 columns and K^2 rows (multi-jittered
    samples without the jitter; Chiu, Shirley and Wang, "Multi-jittered sampling", Graphics Gems IV,
    1994): what is rounded in u or v alone has 1 / (2 K^2) px of its rounding left at most.
    """
    cell, within = np.divmod(np.arange(steps**2), steps)
    first = (cell + (within + 0.5) / steps) / steps
    second = (within + (cell + 0.5) / steps) / steps
    return np.stack([first, second], axis=-1) - 0.5


def _moved_back(seen: TipObservation, shift_px: Array) -> TipObservation:
    return seen if seen.tip_px is None else replace(seen, tip_px=seen.tip_px - shift_px)


def _mean(first: TipObservation, moved: list[TipObservation]) -> TipObservation:
    """Give the mean of what was seen in the moved images, counted in pixels of the one as it is."""
    same = [one for one in moved if _is_same(one, first)]
    if len(same) < ENOUGH * len(moved):
        return _failure(first, moved, len(same))
    tip = np.mean([one.tip_px for one in same if one.tip_px is not None], axis=0)
    axes = [one.axis_px for one in same if one.axis_px is not None]
    axis = np.sum(axes, axis=0) if axes else None
    # Axes may be opposite, where a detector cannot tell a needle's ends.
    axis = axis if axis is not None and axis.any() else first.axis_px
    return replace(first, tip_px=tip, axis_px=axis)


def _is_same(one: TipObservation, first: TipObservation) -> bool:
    if one.tip_px is None or first.tip_px is None:
        return False
    return bool(np.linalg.norm(one.tip_px - first.tip_px) <= SAME_PX)


def _failure(first: TipObservation, moved: list[TipObservation], same: int) -> TipObservation:
    """Say why there is no mean: by the first failure, or that the tips are of several things."""
    count = f"the tip was found again in {same} of {len(moved)} images moved by parts of a pixel"
    failed = [one for one in moved if not one.ok]
    if not failed:
        reason = f"{count}, and more than {SAME_PX:g} px away in the others"
        return TipObservation.failed(TipStatus.NOT_FOUND, reason, layers=first.layers)
    reason = f"{failed[0].reason} [{count}]"
    return TipObservation.failed(failed[0].status, reason, layers=first.layers)
