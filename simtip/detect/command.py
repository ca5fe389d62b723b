"""An external program as a detector: an image file in, JSON on standard output."""

from __future__ import annotations

import json
import shutil
import signal
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NoReturn, cast

from simtip.detect.excerpt import excerpt
from simtip.detect.guarded import GuardedDetector
from simtip.detect.handed_over import ImageFormat, handed_over
from simtip.detect.observation import TipObservation, TipStatus
from simtip.detect.parameters import REQUIRED, Declaration, Declared, values_of
from simtip.detect.process import MAX_STDOUT, Finished, run_program
from simtip.detect.protocol import Image
from simtip.detect.template import FIELD, IMAGE, Template, parse_template
from simtip.errors import InputError

PREFIX = "cmd:"
SUMMARY = "an image file in, JSON on standard output out"

OWN = (
    Declaration(
        "timeout_s",
        float,
        60.0,
        Declared("the program is stopped after this time, s", minimum=0.01, maximum=86400),
    ),
    Declaration(
        "image_format",
        ImageFormat,
        "png",
        Declared("of the image file: png keeps every value, pgm is gray and simple to read"),
    ),
)
"""The parameters that every command has."""


def command_detector(reference: str) -> GuardedDetector:
    """Make a detector of ``cmd:PROGRAM ARGUMENT ...``, see docs/your_detector.md.

    Parameters
    ----------
    reference
        ``{image}`` stands for the image file, any other ``{place}`` for a parameter of that name.

    Raises
    ------
    InputError
        The command is none; see `simtip.detect.template.parse_template`. When it is configured:
        there is no such program, or it may not be executed.
    """
    template = parse_template(reference.removeprefix(PREFIX))
    own = {declaration.name for declaration in OWN}
    places = [
        Declaration(place, str, REQUIRED, Declared(f"put in the place of {{{place}}}"))
        for place in template.places
        if place not in own
    ]
    declarations = (*places, *OWN)

    def prepare(values: Mapping[str, object]) -> Callable[..., object]:
        settings = values_of(declarations, values)
        _require_program(template, settings)
        return _Command(template, settings)

    parameters = tuple(declaration.parameter for declaration in declarations)
    return GuardedDetector(reference, SUMMARY, parameters, prepare)


class _Command:
    """A command with its parameters chosen."""

    def __init__(self, template: Template, settings: Mapping[str, object]) -> None:
        self._template, self._settings = template, settings

    def __call__(self, image: Image, *, layers: bool = False) -> object:
        """Run the program on the image; give what it says, or a failed observation."""
        del layers  # a program has none
        timeout_s = cast("float", self._settings["timeout_s"])
        image_format = cast("ImageFormat", self._settings["image_format"])
        with handed_over(image, image_format) as file:
            arguments = self._template.filled(_texts(self._settings, file))
            try:
                done = run_program(arguments, timeout_s)
            except (OSError, ValueError) as error:
                reason = getattr(error, "strerror", None) or str(error)
                return _failed(f"{arguments[0]} cannot be started: {reason}")
        return _judged(done, arguments, timeout_s)


def _texts(settings: Mapping[str, object], image: Path) -> dict[str, str]:
    return {**{name: str(value) for name, value in settings.items()}, IMAGE: str(image)}


def _require_program(template: Template, settings: Mapping[str, object]) -> None:
    """Refuse a program that cannot be started, before anything has been waited for.

    Raises
    ------
    InputError
        There is no such program, or it may not be executed.
    """
    program = template.filled(_texts(settings, Path()))[0]
    if shutil.which(program) is not None:
        return
    here = Path(program)
    if here.name == program:  # not so of ./x, which lies in a folder that is named
        reason = "no such program in PATH"
        remedy = f"name it with its folder, such as ./{excerpt(program, 60)}"
    elif here.is_dir():
        reason, remedy = "it is a folder", "name a program"
    elif here.exists():
        reason, remedy = "it may not be executed", "allow it (chmod +x), or name its interpreter"
    else:
        reason, remedy = "no such file", "name a program that is there"
    raise InputError(
        f"{excerpt(program, 60)} cannot be started: {reason}", field=FIELD, remedy=remedy
    )


def _judged(done: Finished, arguments: Sequence[str], timeout_s: float) -> object:
    program = excerpt(arguments[0], 60)
    if done.flooded:
        reason = f"{program} wrote more than {MAX_STDOUT} bytes to standard output"
        return _failed(reason, done, TipStatus.INVALID_OUTPUT)
    if done.code is None:
        reason = f"{program} was stopped after {timeout_s:g} s"
        return _failed(reason, done, TipStatus.COMMAND_TIMED_OUT)
    if done.code != 0:
        return _failed(f"{program} ended with {_ending(done.code)}", done)
    if not done.stdout.strip():
        reason = f"{program} wrote nothing to standard output"
        return _failed(reason, done, TipStatus.INVALID_OUTPUT)
    try:
        said: object = json.loads(done.stdout.decode("utf-8-sig"), parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        begin = excerpt(done.stdout.decode("utf-8", "replace"), 80)
        reason = f"{program} wrote no JSON ({excerpt(str(error), 80)}) but: {begin}"
        return _failed(reason, done, TipStatus.INVALID_OUTPUT)
    return said


def _failed(
    problem: str, done: Finished | None = None, status: TipStatus = TipStatus.COMMAND_FAILED
) -> TipObservation:
    said = "" if done is None else excerpt(done.stderr.decode("utf-8", "replace"))
    return TipObservation.failed(status, f"{problem}; it said: {said}" if said else problem)


def _ending(code: int) -> str:
    if code > 0:
        return f"exit code {code}"
    try:
        return f"signal {signal.Signals(-code).name}"
    except ValueError:
        return f"signal {-code}"


def _no_number(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number in JSON")
