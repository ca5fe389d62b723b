"""JSON that simtip wrote, read as data."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from simtip.errors import InputError
from simtip.input_file import read_bytes

MAX_BYTES = 1 << 30


def read_json(file: Path, remedy: str) -> dict[str, Any]:
    """Read a JSON object.

    Raises
    ------
    InputError
        The file cannot be read, is cut short, or holds something else.
    """
    data = read_bytes(file, MAX_BYTES)
    try:
        found = json.loads(data)
    except (ValueError, RecursionError):
        raise InputError("is cut short or no JSON", file=file, remedy=remedy) from None
    if not isinstance(found, dict):
        raise InputError("is no JSON object", file=file, remedy=remedy)
    return found
