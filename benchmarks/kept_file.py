"""JSON files that are there whole or not at all, whenever the work is interrupted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def keep_json(path: Path, data: dict[str, Any]) -> None:
    """Write a file in the place of an older one, at one stroke."""
    new = path.with_name(f".{path.name}.new")
    new.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n")
    new.replace(path)
