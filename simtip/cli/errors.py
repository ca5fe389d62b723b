"""What a user did wrong, in one line on standard error."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import typer

from simtip.detect.excerpt import printable
from simtip.errors import InputError
from simtip.interrupts import INTERRUPTED, no_more
from simtip.scene_file import SceneFile

# Typer brings its own copy of click, of which only the leaves are public.
ClickError: Any = next(
    kind for kind in typer.BadParameter.__mro__ if kind.__name__ == "ClickException"
)


@contextmanager
def located(scene: SceneFile) -> Iterator[None]:
    """Give an error about a scene's field its file and line."""
    try:
        yield
    except InputError as error:
        if error.file is None and error.field is not None and not error.field.startswith("-"):
            raise scene.error(error.problem, error.field, remedy=error.remedy) from error
        raise


@contextmanager
def as_option(option: str) -> Iterator[None]:
    """Give an error about what an option says the option's name."""
    try:
        yield
    except InputError as error:
        raise InputError(
            error.problem, file=error.file, field=option, remedy=error.remedy
        ) from error


def usage(error: Any) -> str:
    """Say what is wrong with the arguments, and where help is."""
    context = getattr(error, "ctx", None)
    command = context.command_path if context else "simtip"
    problem = error.format_message().replace("Value error, ", "").rstrip(".?")
    return f"{problem}; see `{command} --help`"


def fail(message: str, code: int) -> NoReturn:
    """Say it in one line on standard error, and leave with that exit code."""
    if code == INTERRUPTED:
        no_more()
    # Names of files and keys may hold anything, such as codes that clear the terminal.
    line = printable(" ".join(message.split()))
    if sys.stderr is not None:
        sys.stderr.write(f"simtip: {line}\n")
    sys.exit(code)
