"""YAML as plain data with line numbers; nothing in a file is ever executed or instantiated.

PyYAML only splits the text into events. What those events mean is decided here, by the core schema
of YAML 1.2 (section 10.3): ``1e-3`` is a number, ``on`` and ``yes`` are text. Depth, number of
values and size are bounded, so that a hostile file costs neither the stack nor the memory.
"""

from __future__ import annotations

import re
import stat
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import yaml

from simtip.errors import InputError

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator

Yaml: TypeAlias = "dict[str, Yaml] | list[Yaml] | str | int | float | bool | None"
FieldPath: TypeAlias = tuple[str | int, ...]

MAX_BYTES = 256 * 1024
"""Largest YAML file read: a hundred times the scene files that simtip comes with."""
MAX_DEPTH = 64
"""Deepest nesting of lists and mappings, aliases followed."""
MAX_VALUES = 50_000
"""Most keys and values in a file, aliases expanded; 32 characters of text count as one more."""
MAX_NUMBER_LENGTH = 300
"""Longest number, in characters: any integer of that length still fits a float."""

_NULL = re.compile(r"(?:~|null|Null|NULL|)\Z")
_TRUE = re.compile(r"(?:true|True|TRUE)\Z")
_FALSE = re.compile(r"(?:false|False|FALSE)\Z")
_INT = re.compile(r"[-+]?[0-9]+\Z")
_OCTAL = re.compile(r"0o[0-7]+\Z")
_HEX = re.compile(r"0x[0-9a-fA-F]+\Z")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?\Z")
_INF = re.compile(r"[-+]?(?:\.inf|\.Inf|\.INF)\Z")
_NAN = re.compile(r"(?:\.nan|\.NaN|\.NAN)\Z")
_UNPRINTABLE = re.compile(
    "[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"
)
_YAML_TAGS = "tag:yaml.org,2002:"


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
            text += ("." if text else "") + (part if len(part) <= 60 else part[:57] + "...")
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
    text = str(value)
    text = text if len(text) <= 40 else text[:37] + "..."
    return f"the text {text!r}" if isinstance(value, str) else text


def read_bytes(path: str | Path, max_bytes: int) -> bytes:
    """Read a regular file that a user named.

    Parameters
    ----------
    path
        The file.
    max_bytes
        The largest size accepted.

    Raises
    ------
    InputError
        The file is missing, a folder, a device or pipe, unreadable, empty or too large.
    """
    try:
        file = Path(path)
        size = _regular_size(file.stat(), path, max_bytes)
        with file.open("rb") as stream:
            data = stream.read(size)
    except InputError:
        raise
    except (FileNotFoundError, NotADirectoryError):
        raise InputError("no such file", file=path, remedy="check the path") from None
    except PermissionError:
        raise InputError("may not be read", file=path, remedy="check its permissions") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"cannot be read ({reason})", file=path, remedy="check the path"
        ) from error
    if not data:
        raise InputError("is empty", file=path, remedy="was it written to the end?")
    return data


def _regular_size(info: os.stat_result, path: str | Path, max_bytes: int) -> int:
    if stat.S_ISDIR(info.st_mode):
        raise InputError("is a folder", file=path, remedy="name a file")
    # A pipe or device may never end.
    if not stat.S_ISREG(info.st_mode):
        raise InputError("is not a regular file", file=path, remedy="save it to disk first")
    if info.st_size > max_bytes:
        raise InputError(
            f"has {info.st_size} bytes, more than the limit of {max_bytes}",
            file=path,
            remedy="is it the right file?",
        )
    return info.st_size


def load_yaml(path: str | Path, max_bytes: int = MAX_BYTES, *, opencv: bool = False) -> Document:
    """Read a UTF-8 YAML file of one document as plain data.

    Parameters
    ----------
    path
        The file.
    max_bytes
        The largest size accepted.
    opencv
        Also accept what OpenCV's FileStorage writes, see `parse_yaml`.

    Raises
    ------
    InputError
        Whatever is wrong with the file, in one line with its line number.
    """
    return parse_yaml(read_bytes(path, max_bytes), path, opencv=opencv)


def parse_yaml(data: bytes, file: str | Path, *, opencv: bool = False) -> Document:
    """Parse UTF-8 YAML of one document as plain data.

    Anchors, aliases and merge keys (``<<``) are followed. Tags, keys that are not text, duplicate
    keys and aliases that contain themselves are errors.

    Parameters
    ----------
    data
        The file's bytes.
    file
        Its name, for messages.
    opencv
        Also accept what OpenCV's FileStorage writes and YAML does not know: a first line
        ``%YAML:1.0``, tags ``!!opencv-...`` (ignored) and ``.Nan``.

    Raises
    ------
    InputError
        Whatever is wrong, in one line with its line number.
    """
    text = _text(data, file)
    if opencv and text.startswith("%YAML:"):
        text = "#" + text
    root = _Composer(str(file), opencv=opencv).compose(text)
    lines: dict[FieldPath, int] = {}
    value = _plain(root, (), root.line, lines)
    return Document(str(file), value, lines)


def dump_yaml(value: Yaml) -> str:
    """Write plain data as YAML that `parse_yaml` reads back exactly."""
    text: str = yaml.dump(
        value,
        Dumper=_Dumper,
        sort_keys=False,
        default_flow_style=None,
        allow_unicode=True,
        width=100,
    )
    return text


def _text(data: bytes, file: str | Path) -> str:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"is not UTF-8 text (byte 0x{data[error.start]:02x})",
            file=file,
            line=data.count(b"\n", 0, error.start) + 1,
            remedy="save it as UTF-8",
        ) from None
    bad = _UNPRINTABLE.search(text)
    if bad:
        raise InputError(
            f"holds the control character U+{ord(bad.group()):04X}",
            file=file,
            line=text.count("\n", 0, bad.start()) + 1,
            remedy="is it a text file?",
        )
    return text


@dataclass(eq=False)
class _Node:
    """A value before aliases are expanded; ``weight`` and ``depth`` count them as expanded."""

    line: int
    value: Yaml = None
    items: list[_Node] | None = None
    pairs: dict[str, tuple[int, _Node]] | None = None
    weight: int = 1
    depth: int = 0

    def children(self) -> list[_Node]:
        if self.pairs is not None:
            return [node for _, node in self.pairs.values()]
        return self.items or []


@dataclass(eq=False)
class _Open:
    """A list or mapping whose end has not come yet."""

    node: _Node
    anchor: str | None
    key: tuple[str, int] | None = None
    merge: int | None = None
    merged: list[_Node] = field(default_factory=list)

    def wants_key(self) -> bool:
        return self.node.pairs is not None and self.key is None and self.merge is None


class _Composer:
    """Builds the tree of nodes from PyYAML's events, without recursion."""

    def __init__(self, file: str, *, opencv: bool) -> None:
        self.file = file
        self.opencv = opencv
        self.stack: list[_Open] = []
        self.anchors: dict[str, _Node | None] = {}
        self.root: _Node | None = None
        self.seen = 0

    def compose(self, text: str) -> _Node:
        documents = 0
        for event in self._events(text):
            line = 1 if event.start_mark is None else event.start_mark.line + 1
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise self._error("holds more than one document", line, "keep the first")
            elif isinstance(event, yaml.AliasEvent):
                self._alias(event.anchor, line)
            elif isinstance(event, yaml.ScalarEvent):
                self._scalar(event, line)
            elif isinstance(event, yaml.SequenceStartEvent | yaml.MappingStartEvent):
                self._begin(event, line)
            elif isinstance(event, yaml.SequenceEndEvent | yaml.MappingEndEvent):
                self._end()
        if self.root is None or (self.root.value is None and not self._holds_collection()):
            raise InputError("is empty: it holds no values", file=self.file, remedy="fill it in")
        return self.root

    def _holds_collection(self) -> bool:
        return self.root is not None and (
            self.root.items is not None or self.root.pairs is not None
        )

    def _events(self, text: str) -> Iterator[yaml.Event]:
        parser = yaml.parse(text, Loader=yaml.SafeLoader)
        while True:
            try:
                event = next(parser)
            except StopIteration:
                return
            except yaml.MarkedYAMLError as error:
                mark = error.problem_mark or error.context_mark
                where = None if mark is None else mark.line + 1
                problem = _clipped(error.problem or error.context or "syntax error")
                raise self._error(f"is not valid YAML: {problem}", where, "correct it") from None
            except (yaml.YAMLError, ValueError, OverflowError) as error:
                # PyYAML lets int() and chr() fail on hostile escapes and version numbers.
                raise self._error(
                    f"is not valid YAML: {_clipped(str(error))}", None, "correct it"
                ) from None
            yield event

    def _error(self, problem: str, line: int | None, remedy: str | None) -> InputError:
        names = [frame.key[0] for frame in self.stack if frame.key is not None]
        return InputError(
            problem,
            file=self.file,
            line=line,
            field=dotted(tuple(names)) or None,
            remedy=remedy,
        )

    def _count(self, line: int, depth: int, weight: int) -> None:
        if depth > MAX_DEPTH:
            raise self._error(
                f"is nested deeper than {MAX_DEPTH} levels", line, "write it with fewer levels"
            )
        if weight > MAX_VALUES:
            raise self._error(
                f"expands to more than {MAX_VALUES} values", line, "write fewer values or aliases"
            )

    def _check_tag(self, tag: str | None, line: int) -> None:
        if tag is None:
            return
        short = "!!" + tag[len(_YAML_TAGS) :] if tag.startswith(_YAML_TAGS) else tag
        if not (self.opencv and short.startswith("!!opencv-")):
            raise self._error(
                f"the tag {_clipped(short)} is not allowed",
                line,
                "remove it: plain values only",
            )

    def _begin(self, event: yaml.CollectionStartEvent, line: int) -> None:
        self._check_tag(event.tag, line)
        if self.stack and self.stack[-1].wants_key():
            raise self._error("a key is a list or a mapping", line, "keys have to be text")
        self._count(line, len(self.stack) + 1, self.seen)
        if isinstance(event, yaml.MappingStartEvent):
            node = _Node(line, pairs={})
        else:
            node = _Node(line, items=[])
        if event.anchor is not None:
            self.anchors[event.anchor] = None  # not finished: an alias to it would be endless
        self.stack.append(_Open(node, event.anchor))

    def _end(self) -> None:
        frame = self.stack.pop()
        node = frame.node
        if node.pairs is not None:
            for source in frame.merged:
                for key, pair in (source.pairs or {}).items():
                    node.pairs.setdefault(key, pair)
            node.weight += sum(_weight(key) for key in node.pairs)
        children = node.children()
        node.weight += sum(child.weight for child in children)
        node.depth = 1 + max((child.depth for child in children), default=0)
        self._add(node, frame.anchor)

    def _scalar(self, event: yaml.ScalarEvent, line: int) -> None:
        self._check_tag(event.tag, line)
        plain = event.implicit[0]
        bad = _UNPRINTABLE.search(event.value)
        if bad:
            raise self._error(
                f"holds the control character U+{ord(bad.group()):04X}", line, "remove it"
            )
        if self.stack and self.stack[-1].wants_key():
            self._key(event.value, line, plain=plain)
            return
        value = self._resolve(event.value, line) if plain else event.value
        self._add(_Node(line, value=value, weight=_weight(event.value)), event.anchor)

    def _key(self, text: str, line: int, *, plain: bool) -> None:
        frame = self.stack[-1]
        pairs = frame.node.pairs
        if plain and text == "<<":
            if frame.merged:
                raise self._error("duplicate key '<<'", line, "give it one list of aliases")
            frame.merge = line
            return
        key = self._resolve(text, line) if plain else text
        if not isinstance(key, str):
            raise self._error(
                f"the key {_clipped(text) or 'null'} is not text", line, "put it in quotes"
            )
        if pairs is not None and key in pairs:
            raise self._error(
                f"duplicate key {_clipped(key)!r}, first on line {pairs[key][0]}",
                line,
                "keep one of them",
            )
        self.seen += 1
        frame.key = (key, line)

    def _alias(self, anchor: str | None, line: int) -> None:
        name = _clipped(anchor or "")
        if self.stack and self.stack[-1].wants_key():
            raise self._error(f"the alias *{name} is a key", line, "write the key as text")
        if anchor not in self.anchors:
            raise self._error(f"the alias *{name} has no anchor &{name}", line, "define it before")
        node = self.anchors[anchor]
        if node is None:
            raise self._error(f"the alias *{name} contains itself", line, "write the values")
        self._add(node, None, line)

    def _add(self, node: _Node, anchor: str | None, line: int | None = None) -> None:
        """Put a finished node where it belongs."""
        line = node.line if line is None else line
        self.seen += 1
        if anchor is not None:
            self.anchors[anchor] = node
        self._count(line, len(self.stack) + node.depth, max(self.seen, node.weight))
        if not self.stack:
            self.root = node
            return
        frame = self.stack[-1]
        if frame.merge is not None:
            frame.merged = self._mergeable(node, frame.merge)
            frame.merge = None
        elif frame.node.pairs is not None and frame.key is not None:
            key, key_line = frame.key
            frame.node.pairs[key] = (key_line, node)
            frame.key = None
        elif frame.node.items is not None:
            frame.node.items.append(node)

    def _mergeable(self, node: _Node, line: int) -> list[_Node]:
        sources = [node] if node.items is None else node.items
        if not sources or any(source.pairs is None for source in sources):
            raise self._error("'<<' merges what is not a mapping", line, "give it mappings")
        return sources

    def _resolve(self, text: str, line: int) -> str | int | float | bool | None:
        """Give a plain scalar its value by the core schema (YAML 1.2.2, section 10.3.2)."""
        if _NULL.match(text):
            return None
        if _TRUE.match(text) or _FALSE.match(text):
            return text[0] in "tT"
        if _INF.match(text):
            return float(text.replace(".", ""))
        if _NAN.match(text) or (self.opencv and text == ".Nan"):
            return float("nan")
        if any(pattern.match(text) for pattern in (_INT, _OCTAL, _HEX, _FLOAT)):
            return self._number(text, line)
        return text

    def _number(self, text: str, line: int) -> int | float:
        if len(text) > MAX_NUMBER_LENGTH:
            raise self._error(
                f"a number of {len(text)} characters is too long",
                line,
                "write fewer digits, or quote it if it is text",
            )
        if _INT.match(text):
            return int(text)
        if _OCTAL.match(text) or _HEX.match(text):
            return int(text, 0)
        number = float(text)
        if number in (float("inf"), float("-inf")):
            raise self._error(
                f"the number {_clipped(text)} is too large", line, "write a smaller one"
            )
        return number


def _weight(text: str) -> int:
    return 1 + len(text) // 32


def _clipped(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:57] + "..."


def _plain(node: _Node, path: FieldPath, line: int, lines: dict[FieldPath, int]) -> Yaml:
    # Recursion is safe: `_Composer` bounds the depth and the number of values.
    lines[path] = line
    if node.pairs is not None:
        return {
            key: _plain(child, (*path, key), key_line, lines)
            for key, (key_line, child) in node.pairs.items()
        }
    if node.items is not None:
        return [
            _plain(child, (*path, index), child.line, lines)
            for index, child in enumerate(node.items)
        ]
    return node.value


class _Dumper(yaml.SafeDumper):
    """Writes what the core schema reads back: no aliases, floats at full precision."""

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002 - PyYAML's signature
        return True


def _represent_float(dumper: yaml.SafeDumper, number: float) -> yaml.ScalarNode:
    # repr() is the shortest text that reads back to the same float.
    special = {"inf": ".inf", "-inf": "-.inf", "nan": ".nan"}
    text = repr(number)
    return dumper.represent_scalar(_YAML_TAGS + "float", special.get(text, text))


# PyYAML follows YAML 1.1, where 1e-3 and 08 are text: told of both schemas, it puts quotes around
# any text that either would take for something else.
_Dumper.add_representer(float, _represent_float)
_Dumper.add_implicit_resolver(_YAML_TAGS + "float", _FLOAT, list("-+.0123456789"))
for _pattern in (_INT, _OCTAL, _HEX):
    _Dumper.add_implicit_resolver(_YAML_TAGS + "int", _pattern, list("-+0123456789"))
