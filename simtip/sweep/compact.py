"""Parts and lists, which a table of results holds as JSON, as people read them."""

from __future__ import annotations

import json
from typing import Any

KIND = "kind"


def compact(text: str) -> str:
    """Write ``{"kind": "cone", "length_mm": 5}`` as ``cone length_mm=5``; other text as it is."""
    if not text.startswith(("{", "[")):
        return text
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return text
    return _part(value) if isinstance(value, dict) and value else _value(value)


def _part(part: dict[str, Any]) -> str:
    kind = part.get(KIND)
    named = isinstance(kind, str)
    words = [f"{name}={_value(x)}" for name, x in part.items() if not (named and name == KIND)]
    return " ".join([kind, *words] if isinstance(kind, str) else words)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return f"({_part(value)})"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return value if isinstance(value, str) else json.dumps(value)
