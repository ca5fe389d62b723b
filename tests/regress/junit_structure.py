"""What JUnit XML may look like, as the readers of it agree.

The facts are those of the schema `junit-10.xsd` of Jenkins' xUnit plug-in (jenkinsci/xunit-plugin),
which pytest's own XML is held to, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree import ElementTree as ET

COUNTS = {"tests", "failures", "errors", "skipped"}


@dataclass(frozen=True)
class Element:
    """What an element has to have, may have besides, and may hold."""

    required: frozenset[str]
    optional: frozenset[str]
    children: frozenset[str]
    text: bool = False


def _element(required: str, optional: str, children: str, *, text: bool = False) -> Element:
    return Element(*(frozenset(x.split()) for x in (required, optional, children)), text=text)


KNOWN = {
    "testsuites": _element("", "name time tests failures errors", "testsuite"),
    "testsuite": _element(
        "name tests failures errors",
        "group time skipped timestamp hostname id package file log url",
        "testsuite properties testcase system-out system-err",
    ),
    "testcase": _element(
        "name", "time classname group", "skipped error failure system-out system-err"
    ),
    "failure": _element("", "type message", "", text=True),
    "error": _element("", "type message", "", text=True),
    "system-out": _element("", "", "", text=True),
}


def strange(root: ET.Element) -> list[str]:
    """List what is not as the schema has it."""
    found = [] if root.tag in {"testsuites", "testsuite"} else [f"the root is {root.tag}"]
    return [*found, *_strange(root)]


def _strange(one: ET.Element) -> Iterator[str]:
    known = KNOWN.get(one.tag)
    if known is None:
        yield f"no element {one.tag}"
        return
    has = set(one.attrib)
    yield from (f"{one.tag} lacks {name}" for name in known.required - has)
    yield from (f"{one.tag} has {name}" for name in has - known.required - known.optional)
    yield from (f"{one.tag} holds {c.tag}" for c in one if c.tag not in known.children)
    yield from (f"{name} is no count" for name in COUNTS & has if not one.attrib[name].isdigit())
    if not known.text and (one.text or "").strip():
        yield f"{one.tag} holds text"
    for child in one:
        yield from _strange(child)
