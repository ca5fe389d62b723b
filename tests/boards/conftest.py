from __future__ import annotations

import contextlib
import io

import pytest
from cli.command_line import Answer

from simtip.cli import main


@pytest.fixture
def ask():
    """Call the command line in this process."""

    def call(*arguments: str) -> Answer:
        out, err = io.StringIO(), io.StringIO()
        with (
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(err),
            pytest.raises(SystemExit) as ended,
        ):
            main(list(arguments))
        return Answer(int(ended.value.code), out.getvalue(), err.getvalue())

    return call
