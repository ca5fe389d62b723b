"""JSON (RFC 8259) to plain data, within limits."""

from __future__ import annotations

import json
import math
from pathlib import Path

from simtip.errors import InputError
from simtip.yaml_file import Document, Yaml
from simtip.yaml_file.compose import MAX_DEPTH, MAX_VALUES
from simtip.yaml_file.document import clipped
from simtip.yaml_file.scalars import MAX_NUMBER_LENGTH


class _Reader:
    """The hooks of `json.loads`, which refuse what JSON or a rig does not have."""

    def __init__(self, file: str) -> None:
        self.file = file

    def error(self, problem: str, remedy: str, line: int | None = None) -> InputError:
        return InputError(problem, file=self.file, line=line, remedy=remedy)

    def whole(self, text: str) -> int:
        if len(text) > MAX_NUMBER_LENGTH:
            raise self.error(f"has a number of {len(text)} digits", "write a smaller one")
        return int(text)

    def fraction(self, text: str) -> float:
        number = float(text)
        if math.isinf(number):
            raise self.error(f"has the number {clipped(text, 40)}", "write a smaller one")
        return number

    def constant(self, text: str) -> float:
        raise self.error(f"has {text}, which is no number in JSON", "give finite numbers")

    def pairs(self, pairs: list[tuple[str, Yaml]]) -> dict[str, Yaml]:
        found = dict(pairs)
        if len(found) < len(pairs):
            names = [name for name, _ in pairs]
            twice = next(name for name in names if names.count(name) > 1)
            raise self.error(f"has the key {clipped(twice, 40)!r} twice", "keep one of them")
        return found


def parse_json(data: bytes, file: str | Path) -> Document:
    """Parse UTF-8 JSON as plain data; its values' lines are not known.

    Parameters
    ----------
    data
        The file's bytes.
    file
        Its name, for messages.

    Raises
    ------
    InputError
        Whatever is wrong: no valid JSON, duplicate keys, NaN or infinity, a number that no float
        holds, deep nesting, too many values.
    """
    reader = _Reader(str(file))
    try:
        value: Yaml = json.loads(
            data.decode("utf-8-sig"),
            parse_int=reader.whole,
            parse_float=reader.fraction,
            parse_constant=reader.constant,
            object_pairs_hook=reader.pairs,
        )
    except InputError:
        raise
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise reader.error("is not UTF-8 text", "save it as UTF-8", line) from None
    except json.JSONDecodeError as error:
        raise reader.error(f"is not valid JSON: {error.msg}", "correct it", error.lineno) from None
    except RecursionError:
        raise _too_deep(reader) from None
    _check_size(reader, value)
    return Document(str(file), value, {})


def _check_size(reader: _Reader, value: Yaml) -> None:
    seen, level = 0, [value]
    for _ in range(MAX_DEPTH + 1):
        seen += len(level)
        if seen > MAX_VALUES:
            raise reader.error(f"has more than {MAX_VALUES} values", "is it the right file?")
        level = [inner for outer in level for inner in _inside(outer)]
        if not level:
            return
    raise _too_deep(reader)


def _inside(value: Yaml) -> list[Yaml]:
    if isinstance(value, dict):
        return list(value.values())
    return value if isinstance(value, list) else []


def _too_deep(reader: _Reader) -> InputError:
    return reader.error(f"is nested deeper than {MAX_DEPTH} levels", "write it with fewer levels")
