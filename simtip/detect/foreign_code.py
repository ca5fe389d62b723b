"""Code that others wrote, run so that its faults end in one sentence and not the whole run."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from simtip.detect.excerpt import excerpt
from simtip.errors import InputError

OUR_FOLDER = Path(__file__).parent


class ForeignCodeError(Exception):
    """Somebody's code raised an exception; the text names its type, its message and its place."""


@contextmanager
def foreign_code() -> Iterator[None]:
    """Turn whatever the block raises into a `ForeignCodeError`.

    `InputError` (the image or a value does not suit) and an interrupt by the user pass.
    """
    try:
        yield
    except (InputError, ForeignCodeError):
        raise
    except KeyboardInterrupt:
        raise
    # Any exception, by design: it is not ours. `sys.exit` in there must not end the run either, nor
    # what Rust's panics and others' outcomes are made of.
    except BaseException as error:
        raise ForeignCodeError(_told(error)) from error


def _told(error: BaseException) -> str:
    # Python's own words: safe even where the exception cannot be turned into text.
    said = "".join(traceback.format_exception_only(error))
    place = _place(error.__traceback__)
    return excerpt(said) + (f" ({excerpt(place, 80)})" if place else "")


def _place(trace: TracebackType | None) -> str:
    """Name the last line of the file that was called, not one deep inside a library of its."""
    frames = [
        frame
        for frame in traceback.extract_tb(trace)
        if not Path(frame.filename).is_relative_to(OUR_FOLDER)
        and "importlib" not in frame.filename
        and Path(frame.filename).name != "contextlib.py"
    ]
    if not frames:
        return ""
    own = [frame for frame in frames if frame.filename == frames[0].filename]
    return f"{Path(own[-1].filename).name}:{own[-1].lineno} in {own[-1].name}"
