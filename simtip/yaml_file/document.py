"""A YAML document as plain data, and how its values and places are named in messages."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TypeAlias

from simtip.errors import InputError

Yaml: TypeAlias = "dict[str, Yaml] | list[Yaml] | str | int | float | bool | None"
FieldPath: TypeAlias = tuple[str | int, ...]


@dataclass(frozen=True)
class Document:
    """A YAML document as plain data, and where each value stands.

    Attributes
    ----------
    file
        The file's name, for messages.
    value
        The data: dict (text keys), list, str, int, float, bool or None.
    lines
        1-based line of every value by its path of keys and indices; of a mapping's value, the
        line of its key. A value reached by an alias has the line where it is written.
    """

    file: str
    value: Yaml
    lines: dict[FieldPath, int]

    def line(self, path: FieldPath) -> int | None:
        """Give the 1-based line of a value, or of the nearest part around it that is written."""
        for end in range(len(path), -1, -1):
            if path[:end] in self.lines:
                return self.lines[path[:end]]
        return None

    def error(self, problem: str, path: FieldPath = (), *, remedy: str | None = None) -> InputError:
        """Make the error that names this file, the value's line and its dotted path."""
        return InputError(
            problem,
            file=self.file,
            line=self.line(path),
            field=dotted(path) or None,
            remedy=remedy,
        )


def dotted(path: FieldPath) -> str:
    """Write a path as people do: ``("lamps", 0, "power")`` is ``lamps[0].power``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += ("." if text else "") + clipped(part, 60)
    return text


def undotted(text: str) -> FieldPath:
    """Read a dotted path: ``lamps[0].power`` is ``("lamps", 0, "power")``."""
    parts = re.findall(r"\[([0-9]{1,9})\]|([^.\[\]]+)", text)
    return tuple(int(index) if index else key for index, key in parts)


def shown(value: object) -> str:
    """Describe a value in a message, briefly, in YAML's words."""
    if value is None:
        return "nothing (null)"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    text = clipped(str(value), 40)
    return f"the text {text!r}" if isinstance(value, str) else text


def clipped(text: str, most: int) -> str:
    """Cut a text short for a message."""
    return text if len(text) <= most else text[: most - 3] + "..."
