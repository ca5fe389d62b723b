"""A page as one HTML file that asks nobody for anything, and runs nothing but its own script."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from simtip.page.parts import Drawing, Page
from simtip.version import __version__

GENERATOR = f"simtip {__version__}"
MARK = '<meta name="generator" content="simtip '
"""By which a file is known to be a page of simtip's."""

SCRIPTS = (
    *("dom", "numbers", "theme", "copying", "viewer", "columns", "conditions", "statistics"),
    *("colours", "axis", "map", "curves", "distributions", "trials", "explorer", "main"),
)
"""In the order in which they need each other."""


_BREAKS = re.compile(r"(?<=[_/])(?=\w)|(?<=[A-Za-z\]]\.)(?=[a-z])")
"""Where a long name may go on in the next line; a number may not."""


def html_of(page: Page) -> str:
    """Write a page.

    Everything that the results say is escaped. The page's policy forbids all other scripts and
    styles, and every connection.
    """
    style, script = _asset("page.css"), "\n".join(_asset(f"{name}.js") for name in SCRIPTS)
    policy = "; ".join(
        (
            "default-src 'none'",
            f"style-src '{_digest(style)}'",
            f"script-src '{_digest(script)}'",
            "img-src data:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    text: str = (
        _environment()
        .get_template("page.html")
        .render(
            page=page,
            policy=policy,
            style=Markup(style),  # noqa: S704 (our own)
            script=Markup(script),  # noqa: S704 (our own)
            settings=Markup(_as_data(page.settings)),  # noqa: S704 (escaped)
            data={name: _packed(content) for name, content in page.data.items()},
            generator=GENERATOR,
            drawn=_drawn,
        )
    )
    # Names of folders, and JSON, may hold what is no Unicode.
    return text.encode(errors="backslashreplace").decode()


def is_page(file: Path) -> bool:
    """Say whether a file is a page that simtip wrote."""
    try:
        if not file.is_file():
            return False
        with file.open("rb") as stream:
            return MARK.encode() in stream.read(4096)
    except OSError:
        return False


def _drawn(drawing: Drawing) -> Markup:
    from simtip.report.themed import themed_svg

    return Markup(themed_svg(drawing.figure, drawing.name, drawing.title))  # noqa: S704 (our own)


def _breakable(text: str) -> Markup:
    """Let names such as ``left_touches_border`` go on in the next line."""
    return Markup("<wbr>").join(_BREAKS.split(text))  # the parts are escaped


def _as_data(value: Any) -> str:
    """Write JSON that no parser of HTML or JavaScript takes for anything else."""
    text = json.dumps(value, allow_nan=False, ensure_ascii=True)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _packed(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, 6, mtime=0)).decode()


def _digest(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


def _asset(name: str) -> str:
    return (files("simtip.page") / "assets" / name).read_text(encoding="utf-8").strip()


@cache
def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("simtip.page", "assets"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["px"] = lambda value: f"{value:.6g}"
    made.filters["breakable"] = _breakable
    return made
