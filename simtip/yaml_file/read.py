"""YAML files to plain data."""

from __future__ import annotations

from pathlib import Path

from simtip.errors import InputError
from simtip.input_file import read_bytes
from simtip.yaml_file.compose import Composer, Node
from simtip.yaml_file.document import Document, FieldPath, Yaml
from simtip.yaml_file.scalars import control_character

MAX_BYTES = 256 * 1024
"""Largest YAML file read: a hundred times the scene files that simtip comes with."""


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
    text = _decoded(data, file)
    if opencv and text.startswith("%YAML:"):
        text = "#" + text
    root = Composer(str(file), opencv=opencv).compose(text)
    lines: dict[FieldPath, int] = {}
    value = _plain(root, (), root.line, lines)
    return Document(str(file), value, lines)


def _decoded(data: bytes, file: str | Path) -> str:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"is not UTF-8 text (byte 0x{data[error.start]:02x})",
            file=file,
            line=data.count(b"\n", 0, error.start) + 1,
            remedy="save it as UTF-8",
        ) from None
    bad = control_character(text)
    if bad:
        raise InputError(
            f"holds the control character {bad[1]}",
            file=file,
            line=text.count("\n", 0, bad[0]) + 1,
            remedy="is it a text file?",
        )
    return text


def _plain(node: Node, path: FieldPath, line: int, lines: dict[FieldPath, int]) -> Yaml:
    # Recursion is safe: `Composer` bounds the depth and the number of values.
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
