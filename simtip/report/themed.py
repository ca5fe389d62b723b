"""Figures as a part of a page: SVG that takes its ink and paper from the page around it.

A page that forbids style attributes and elements (a content security policy without
``unsafe-inline``) still shows them: all looks are attributes of their own.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

from matplotlib.figure import Figure

from simtip.report.style import BLUE, GRAY, GREEN, ORANGE, svg

SVG = "http://www.w3.org/2000/svg"
LINK = "{http://www.w3.org/1999/xlink}href"

THEMED = {
    "#000000": "var(--ink)",
    "#333333": "var(--ink)",
    "#ffffff": "var(--paper)",
    GRAY.lower(): "var(--muted)",
    BLUE.lower(): "var(--blue)",
    ORANGE.lower(): "var(--orange)",
    GREEN.lower(): "var(--green)",
    "#f4f4f4": "var(--sunken)",
    "#b0b0b0": "var(--rule)",
}
"""What the page decides, by what a figure has in its place."""

_REFERENCE = re.compile(r"url\(#([^)]+)\)")


def themed_svg(figure: Figure, name: str, title: str) -> str:
    """Give a figure as an SVG element.

    Parameters
    ----------
    figure
        Drawn in black on white.
    name
        Unlike that of any other figure of the page: its ids begin with it.
    title
        What it shows, for those who do not see it.
    """
    root = ET.fromstring(svg(figure))  # noqa: S314 (our own)
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag in {f"{{{SVG}}}style", f"{{{SVG}}}metadata"}:
                parent.remove(child)
    for element in root.iter():
        _restyle(element)
        _rename(element, name)
        element.tag = element.tag.removeprefix(f"{{{SVG}}}")
    for key in ("width", "height", "version"):
        root.attrib.pop(key, None)
    root.attrib |= {
        "xmlns": SVG,
        "class": "figure",
        "role": "img",
        "aria-label": title,
        "fill": "var(--ink)",
        "stroke-linejoin": "round",
        "stroke-linecap": "butt",
    }
    return ET.tostring(root, encoding="unicode")


def _restyle(element: ET.Element) -> None:
    """Write what its style says as attributes, in the page's colours."""
    style = element.attrib.pop("style", "")
    for said in filter(None, (part.strip() for part in style.split(";"))):
        key, _, value = said.partition(":")
        element.attrib[key.strip()] = value.strip()
    for key in ("fill", "stroke"):
        value = element.attrib.get(key, "")
        element.attrib.update({key: THEMED[value]} if value in THEMED else {})


def _rename(element: ET.Element, name: str) -> None:
    """Make ids the figure's own, and with them what refers to them."""
    if "id" in element.attrib:
        element.attrib["id"] = f"{name}-{element.attrib['id']}"
    target = element.attrib.pop(LINK, None)
    if target is not None:
        own = target.startswith("#")
        # Colour bars are pictures, written in lines.
        element.attrib["href"] = f"#{name}-{target[1:]}" if own else "".join(target.split())
    for key, value in element.attrib.items():
        element.attrib[key] = _REFERENCE.sub(rf"url(#{name}-\1)", value)
