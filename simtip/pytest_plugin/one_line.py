"""A mistake in what a test asks for is one line of its report, without a traceback."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from simtip.errors import SimtipError


@contextmanager
def in_one_line() -> Iterator[None]:
    """Let a test, or its collection, fail with the one line that an error of simtip's is."""
    try:
        yield
    except SimtipError as error:
        raise pytest.fail.Exception(f"simtip: {error}", pytrace=False) from None
