"""Which detector, its parameters and where it looks: the options of every command that detects."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from typing import Annotated

import typer

from simtip.camera import Camera
from simtip.cli.errors import as_option
from simtip.detect import (
    ConfiguredDetector,
    Image,
    Region,
    TipObservation,
    configure,
    parse_region,
)
from simtip.detect.parameters import FIELD_PREFIX
from simtip.detect.protocol import for_camera
from simtip.errors import InputError

DetectorOption = Annotated[
    str,
    typer.Option(
        "--detector",
        metavar="REF",
        help="A name of `simtip detectors`, module:function, or 'cmd:PROGRAM {image}'.",
    ),
]
SettingsOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Detector parameter; repeatable."),
]


def parse_settings(settings: list[str] | None) -> dict[str, object]:
    """Give what every ``--set KEY=VALUE`` says, as text by name; the last of equal names wins."""
    values: dict[str, object] = {}
    for setting in settings or []:
        key, equals, value = (part.strip() for part in setting.partition("="))
        if not equals or not key:
            raise InputError(
                f"{setting!r} is not KEY=VALUE", field="--set", remedy="write e.g. threshold=105"
            )
        if key == "name":
            raise InputError("is no parameter", field="--set name", remedy="give --detector REF")
        values[key] = value
    return values


def parse_roi(text: str | None, option: str) -> Region | None:
    """Read a region from an option, which errors name."""
    if text is None:
        return None
    with as_option(option):
        return parse_region(text)


@contextmanager
def as_detector_options(given: Collection[str] | None = None) -> Iterator[None]:
    """Give an error about a detector's parameter the name of the option, not of a scene's field.

    `given` names the parameters that stand on the command line, with ``name`` for the detector
    itself, where a scene gives others; None is all.
    """
    try:
        yield
    except InputError as error:
        part, _, name = (error.field or "").partition(".")
        if part != FIELD_PREFIX or (given is not None and name not in given):
            raise
        option = "--detector" if name == "name" else f"--set {name}"
        raise InputError(
            error.problem, file=error.file, field=option, remedy=error.remedy
        ) from error


@contextmanager
def chatter_aside() -> Iterator[None]:
    """Send what a user's detector prints to standard error: standard output is for the result."""
    with redirect_stdout(sys.stderr):
        yield


def configured(reference: str, settings: list[str] | None) -> ConfiguredDetector:
    """Set up the detector that the options name; its chatter goes to standard error."""
    with as_detector_options(), chatter_aside():
        detector = configure(reference, parse_settings(settings))
    return quiet(detector)


@dataclass(frozen=True)
class QuietDetector:
    """A detector whose own prints, whenever it looks at an image, go to standard error."""

    detector: ConfiguredDetector

    def __call__(self, image: Image, *, layers: bool = False) -> TipObservation:
        """Look for the needle tip."""
        with chatter_aside():
            return self.detector(image, layers=layers)

    def for_camera(self, camera: Camera) -> ConfiguredDetector:
        """Tell the detector its camera."""
        return QuietDetector(for_camera(self.detector, camera))


def quiet(detector: ConfiguredDetector) -> ConfiguredDetector:
    """Send what the detector prints, whenever it looks at an image, to standard error."""
    return QuietDetector(detector)
