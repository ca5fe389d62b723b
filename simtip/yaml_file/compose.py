"""PyYAML's events to a tree of values, with aliases followed and limits kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import yaml

from simtip.errors import InputError
from simtip.yaml_file.document import Yaml, clipped, dotted
from simtip.yaml_file.scalars import control_character, plain_value

MAX_DEPTH = 64
"""Deepest nesting of lists and mappings, aliases followed."""
MAX_VALUES = 50_000
"""Most keys and values in a file, aliases expanded; 32 characters of text count as one more."""

_YAML_TAGS = "tag:yaml.org,2002:"


@dataclass(eq=False)
class Node:
    """A value before aliases are expanded; ``weight`` and ``depth`` count them as expanded."""

    line: int
    value: Yaml = None
    items: list[Node] | None = None
    pairs: dict[str, tuple[int, Node]] | None = None
    weight: int = 1
    depth: int = 0

    def children(self) -> list[Node]:
        """Give the values of a list or mapping."""
        if self.pairs is not None:
            return [node for _, node in self.pairs.values()]
        return self.items or []


@dataclass(eq=False)
class _Open:
    """A list or mapping whose end has not come yet."""

    node: Node
    anchor: str | None
    key: tuple[str, int] | None = None
    merge: int | None = None
    merged: list[Node] = field(default_factory=list)

    def wants_key(self) -> bool:
        return self.node.pairs is not None and self.key is None and self.merge is None


class Composer:
    """Builds the tree of nodes from PyYAML's events, without recursion."""

    def __init__(self, file: str, *, opencv: bool) -> None:
        self.file = file
        self.opencv = opencv
        self.stack: list[_Open] = []
        self.anchors: dict[str, Node | None] = {}
        self.root: Node | None = None
        self.seen = 0

    def compose(self, text: str) -> Node:
        """Give the root of the text's one document."""
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
                problem = _on_one_line(error.problem or error.context or "syntax error")
                raise self._error(f"is not valid YAML: {problem}", where, "correct it") from None
            except (yaml.YAMLError, ValueError, OverflowError) as error:
                # PyYAML lets int() and chr() fail on hostile escapes and version numbers.
                raise self._error(
                    f"is not valid YAML: {_on_one_line(str(error))}", None, "correct it"
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
                f"the tag {_on_one_line(short)} is not allowed",
                line,
                "remove it: plain values only",
            )

    def _begin(self, event: yaml.CollectionStartEvent, line: int) -> None:
        self._check_tag(event.tag, line)
        if self.stack and self.stack[-1].wants_key():
            raise self._error("a key is a list or a mapping", line, "keys have to be text")
        self._count(line, len(self.stack) + 1, self.seen)
        if isinstance(event, yaml.MappingStartEvent):
            node = Node(line, pairs={})
        else:
            node = Node(line, items=[])
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
        bad = control_character(event.value)
        if bad:
            raise self._error(f"holds the control character {bad[1]}", line, "remove it")
        if self.stack and self.stack[-1].wants_key():
            self._key(event.value, line, plain=plain)
            return
        value = self._resolve(event.value, line) if plain else event.value
        self._add(Node(line, value=value, weight=_weight(event.value)), event.anchor)

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
                f"the key {_on_one_line(text) or 'null'} is not text", line, "put it in quotes"
            )
        if pairs is not None and key in pairs:
            raise self._error(
                f"duplicate key {_on_one_line(key)!r}, first on line {pairs[key][0]}",
                line,
                "keep one of them",
            )
        self.seen += 1
        frame.key = (key, line)

    def _alias(self, anchor: str | None, line: int) -> None:
        name = _on_one_line(anchor or "")
        if self.stack and self.stack[-1].wants_key():
            raise self._error(f"the alias *{name} is a key", line, "write the key as text")
        if anchor not in self.anchors:
            raise self._error(f"the alias *{name} has no anchor &{name}", line, "define it before")
        node = self.anchors[anchor]
        if node is None:
            raise self._error(f"the alias *{name} contains itself", line, "write the values")
        self._add(node, None, line)

    def _add(self, node: Node, anchor: str | None, line: int | None = None) -> None:
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

    def _mergeable(self, node: Node, line: int) -> list[Node]:
        sources = [node] if node.items is None else node.items
        if not sources or any(source.pairs is None for source in sources):
            raise self._error("'<<' merges what is not a mapping", line, "give it mappings")
        return sources

    def _resolve(self, text: str, line: int) -> str | float | bool | None:
        if self.opencv and text == ".Nan":
            return float("nan")
        try:
            return plain_value(text)
        except ValueError as error:
            raise self._error(
                str(error), line, "write a smaller one, or quote it if it is text"
            ) from None


def _weight(text: str) -> int:
    return 1 + len(text) // 32


def _on_one_line(text: str) -> str:
    return clipped(" ".join(text.split()), 60)
