"""What a command says on standard output."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from simtip.errors import InputError


@contextmanager
def to_stdout() -> Iterator[None]:
    """Say in one line that standard output is full or closed; a reader that left is no error."""
    if sys.stdout is None:
        raise InputError("is closed", file="standard output", remedy="send it somewhere")
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        # What is still buffered would fail once more at exit, with a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise InputError(
            f"cannot be written ({error.strerror})",
            file="standard output",
            remedy="free some space or send it elsewhere",
        ) from error


def say(text: str) -> None:
    """Write a line, or several, to standard output."""
    with to_stdout():
        sys.stdout.write(_printable(text) + "\n")


def _printable(text: str) -> str:
    """Write what standard output cannot say as escapes: names of files may hold anything."""
    if sys.stdout.errors not in {None, "strict"}:
        return text
    encoding = sys.stdout.encoding or "utf-8"
    return text.encode(encoding, "backslashreplace").decode(encoding)


def say_aside(text: str) -> None:
    """Write a line to standard error: how far something is."""
    if sys.stderr is not None:
        sys.stderr.write(text + "\n")


def print_json(data: dict[str, Any]) -> None:
    """Write one JSON object, in one line."""
    say(json.dumps(data, allow_nan=False))


def say_where(out: Path | None, what: str) -> None:
    """Say what was written into the folder or file, if there is one."""
    if out is not None:
        say(f"written to {out}: {what}")
