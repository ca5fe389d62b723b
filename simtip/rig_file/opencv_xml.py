"""OpenCV FileStorage XML: read as data by expat without DTDs, and written.

A file is untrusted: it is not given to OpenCV's own parser, and a document type, which is where
entities are declared that expand without end or read other files, is refused.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from simtip.camera import StereoRig
from simtip.errors import InputError
from simtip.geometry import Array
from simtip.rig_file.exact import exact
from simtip.rig_file.opencv import CONVENTIONS, REWRITE, rig_nodes
from simtip.yaml_file import Document, FieldPath, Yaml
from simtip.yaml_file.compose import MAX_DEPTH, MAX_VALUES
from simtip.yaml_file.document import clipped
from simtip.yaml_file.scalars import plain_value

ROOT = "opencv_storage"
ITEM = "_"
"""The name of an element of a sequence."""

_TOKEN = re.compile(r'"[^"]*"|[^\s"]+')
_ALWAYS_LISTS = frozenset({"data", "sizes"})


@dataclass(eq=False)
class _Element:
    name: str
    line: int
    text: list[str] = field(default_factory=list)
    children: list[_Element] = field(default_factory=list)


class _Builder:
    """Builds the tree of elements from expat's events, within limits."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.open: list[_Element] = []
        self.root: _Element | None = None
        self.seen = 0
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._characters

    def build(self, data: bytes) -> _Element:
        try:
            self.parser.Parse(data, True)
        except expat.ExpatError as error:
            problem = expat.errors.messages.get(error.code, "syntax error")
            raise self.error(f"is not valid XML: {problem}", error.lineno, "correct it") from None
        except InputError:
            raise
        except (LookupError, ValueError) as error:  # an encoding that Python does not have
            raise self.error(f"is not valid XML: {error}", 1, "save it as UTF-8") from None
        if self.root is None or self.root.name != ROOT:
            name = "" if self.root is None else clipped(self.root.name, 40)
            raise self.error(f"is XML of <{name}>, not of <{ROOT}>", 1, REWRITE)
        return self.root

    def error(self, problem: str, line: int, remedy: str) -> InputError:
        return InputError(problem, file=self.file, line=line, remedy=remedy)

    def count(self, number: int, line: int) -> None:
        self.seen += number
        if self.seen > MAX_VALUES:
            raise self.error(f"has more than {MAX_VALUES} values", line, "is it the right file?")

    def _doctype(self, *_: object) -> None:
        raise self.error(
            "declares a document type (<!DOCTYPE>), which is not allowed",
            self.parser.CurrentLineNumber,
            "remove it: plain elements only",
        )

    def _start(self, name: str, _: dict[str, str]) -> None:
        line = self.parser.CurrentLineNumber
        element = _Element(name, line)
        if len(self.open) >= MAX_DEPTH:
            raise self.error(
                f"is nested deeper than {MAX_DEPTH} levels", line, "write it with fewer levels"
            )
        self.count(1, line)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def _end(self, _: str) -> None:
        self.open.pop()

    def _characters(self, text: str) -> None:
        self.open[-1].text.append(text)


def parse_opencv_xml(data: bytes, file: str | Path) -> Document:
    """Parse OpenCV FileStorage XML as plain data, in the form that its YAML has.

    Parameters
    ----------
    data
        The file's bytes.
    file
        Its name, for messages.

    Raises
    ------
    InputError
        Whatever is wrong, in one line with its line number.
    """
    builder = _Builder(str(file))
    root = builder.build(data)
    lines: dict[FieldPath, int] = {}
    value = _plain(builder, root, (), lines)
    return Document(str(file), value or {}, lines)


def _plain(
    builder: _Builder, element: _Element, path: FieldPath, lines: dict[FieldPath, int]
) -> Yaml:
    # Recursion is safe: `_Builder` bounds the depth.
    lines[path] = element.line
    values = _scalars(builder, element)
    if element.children and not values and element.children[0].name != ITEM:
        return _named(builder, element, path, lines)
    if element.children:
        return values + [
            _plain(builder, child, (*path, index), lines)
            for index, child in enumerate(element.children, len(values))
        ]
    if len(values) == 1 and element.name not in _ALWAYS_LISTS:
        return values[0]
    return values


def _named(
    builder: _Builder, element: _Element, path: FieldPath, lines: dict[FieldPath, int]
) -> dict[str, Yaml]:
    found: dict[str, Yaml] = {}
    for child in element.children:
        if child.name in found:
            name = clipped(child.name, 40)
            raise builder.error(f"has <{name}> twice", child.line, "keep one of them")
        found[child.name] = _plain(builder, child, (*path, child.name), lines)
    return found


def _scalars(builder: _Builder, element: _Element) -> list[Yaml]:
    words = _TOKEN.findall("".join(element.text))
    builder.count(len(words), element.line)
    return [_scalar(builder, element, word) for word in words]


def _scalar(builder: _Builder, element: _Element, word: str) -> Yaml:
    if word.startswith('"'):
        return word[1:-1]
    if word == ".Nan":
        return float("nan")
    try:
        return plain_value(word)
    except ValueError as error:
        raise builder.error(
            f"in <{clipped(element.name, 40)}>, {error}", element.line, "write a smaller one"
        ) from None


def opencv_xml_text(rig: StereoRig) -> str:
    """Write a rig as OpenCV FileStorage XML."""
    lines = ['<?xml version="1.0"?>', f"<{ROOT}>", *(f"<!-- {line} -->" for line in CONVENTIONS)]
    for name, node in rig_nodes(rig).items():
        if isinstance(node, int):
            lines.append(f"<{name}>{node}</{name}>")
        elif isinstance(node, tuple):
            lines.append(f"<{name}>{node[0]} {node[1]}</{name}>")
        else:
            lines += _matrix_lines(name, node)
    return "\n".join([*lines, f"</{ROOT}>", ""])


def _matrix_lines(name: str, matrix: Array) -> list[str]:
    rows = (" ".join(exact(entry) for entry in row) for row in matrix)
    return [
        f'<{name} type_id="opencv-matrix">',
        f"  <rows>{matrix.shape[0]}</rows>",
        f"  <cols>{matrix.shape[1]}</cols>",
        "  <dt>d</dt>",
        "  <data>",
        "    " + "\n    ".join(rows) + f"</data></{name}>",
    ]
