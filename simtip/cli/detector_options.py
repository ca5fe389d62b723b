"""Which detector, and its parameters: the options of every command that detects."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from simtip.detect.parameters import FIELD_PREFIX
from simtip.errors import InputError


def parse_settings(settings: list[str]) -> dict[str, object]:
    """Give what every ``--set KEY=VALUE`` says, as text by name; the last of equal names wins."""
    values: dict[str, object] = {}
    for setting in settings:
        key, equals, value = (part.strip() for part in setting.partition("="))
        if not equals or not key:
            raise InputError(
                f"{setting!r} is not KEY=VALUE", field="--set", remedy="write e.g. threshold=105"
            )
        values[key] = value
    return values


@contextmanager
def as_detector_options() -> Iterator[None]:
    """Give an error about a detector's parameter the name of the option, not of a scene's field."""
    try:
        yield
    except InputError as error:
        part, _, name = (error.field or "").partition(".")
        if part != FIELD_PREFIX:
            raise
        option = "--detector" if name == "name" else f"--set {name}"
        raise InputError(
            error.problem, file=error.file, field=option, remedy=error.remedy
        ) from error
