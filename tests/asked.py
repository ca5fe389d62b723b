"""The command line called in this process, and what it said."""

from __future__ import annotations

import contextlib
import io
from dataclasses import dataclass

import pytest

from simtip.cli import main


@dataclass(frozen=True)
class Answer:
    """What the command line said."""

    code: int
    out: str
    err: str


def call(*arguments: str) -> Answer:
    """Call it; it always ends by leaving."""
    out, err = io.StringIO(), io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        pytest.raises(SystemExit) as ended,
    ):
        main(list(arguments))
    return Answer(int(ended.value.code), out.getvalue(), err.getvalue())
