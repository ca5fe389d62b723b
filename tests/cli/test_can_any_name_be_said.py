"""Names that standard output cannot hold are said as escapes, and end no command."""

from __future__ import annotations

import io
import sys

import pytest

from simtip.cli.output import say


@pytest.mark.parametrize(
    ("encoding", "name", "said"),
    [
        ("utf-8", "a\udcffb", b"a\\udcffb\n"),
        ("ascii", "\xe9", b"\\xe9\n"),
        ("utf-8", "\xe9", "\xe9\n".encode()),
    ],
)
def test_a_name_is_said_whatever_it_holds(encoding, name, said, monkeypatch):
    stream = io.BytesIO()
    out = io.TextIOWrapper(stream, encoding=encoding, errors="strict", newline="\n")
    monkeypatch.setattr(sys, "stdout", out)
    say(name)
    assert stream.getvalue() == said
