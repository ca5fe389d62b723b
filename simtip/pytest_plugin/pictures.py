"""Pictures of the pairs of a test that has failed: on disk, and named or shown in its report."""

from __future__ import annotations

import base64
import hashlib
import os
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from simtip.errors import InputError
from simtip.image_file import write_png
from simtip.measure import Measurement
from simtip.overlay import side_by_side
from simtip.pytest_plugin.options import artifacts_folder, chosen
from simtip.pytest_plugin.pair import Pair
from simtip.pytest_plugin.used import Used
from simtip.trial_overlay import trial_overlay

PROPERTY = "simtip_picture"
"""Under which a picture's path stands in reports such as JUnit's XML."""

LONGEST_NAME = 80
DRAWN = re.compile(r"[0-9]{2,}_.*\.png")


def attach(item: pytest.Item, report: pytest.TestReport, used: Used) -> None:
    """Write pictures of a failed test's pairs, and name them in its report.

    What cannot be written is said there, too, and is no failure of its own.
    """
    shown, left_out = used.take()
    if not shown:
        return
    lines: list[str] = []
    for pair, measurement in shown.items():
        try:
            path = _written(item, pair, measurement)
        except (InputError, OSError) as error:
            lines.append(f"no picture: {error}")
            break
        lines.append(f"{pair.name}: {_as_named(path, item.config)}")
        item.user_properties.append((PROPERTY, str(path)))
        report.user_properties.append((PROPERTY, str(path)))
        _attach_to_html(item.config, report, pair.name, path)
    if left_out:
        lines.append(f"and {left_out} more, of which there is no picture")
    report.sections.append(("simtip: true and detected tips", "\n".join(lines)))


def remove_old(item: pytest.Item) -> None:
    """Remove what an earlier run of a test has left: it may pass now."""
    folder = _folder_of(item)
    with suppress(OSError):
        for path in folder.iterdir():
            if DRAWN.fullmatch(path.name):
                path.unlink()
        folder.rmdir()


def _written(item: pytest.Item, pair: Pair, measurement: Measurement | None) -> Path:
    folder = _folder_of(item)
    folder.mkdir(parents=True, exist_ok=True)
    if chosen(item.config, "--simtip-artifacts") is None:
        _ignored_by_git(artifacts_folder(item.config))
    number = 1 + sum(1 for path in folder.iterdir() if DRAWN.fullmatch(path.name))
    path = folder / f"{number:02d}_{_plain(pair.name)}.png"
    views = trial_overlay(pair.shot.images, pair.truth, pair.scene, measurement, name=pair.name)
    write_png(path, side_by_side(*views))
    return path


def _ignored_by_git(folder: Path) -> None:
    """Keep the pictures out of what `git add` takes."""
    file = folder / ".gitignore"
    if not file.exists():
        file.write_text("*\n", encoding="utf-8")


def _folder_of(item: pytest.Item) -> Path:
    """Give the folder of a test's pictures: the test's file, then its name with its parameters.

    A test's id would not do: of a file outside the root folder it does not tell the file.
    """
    file, root = item.path, item.config.rootpath
    parts = file.relative_to(root).parts if file.is_relative_to(root) else _outside(file)
    chain = [node.name for node in item.listchain() if isinstance(node, pytest.Class | pytest.Item)]
    name = "-".join(chain)
    readable = name.removesuffix("]").replace("[", "-", 1)
    return artifacts_folder(item.config).joinpath(*map(_own, parts), _own(name, readable))


def _outside(file: Path) -> tuple[str, ...]:
    return str(file.parent), file.name


def _plain(name: str) -> str:
    """Give a name that every file system takes."""
    return re.sub(r"[^\w.=+-]+", "_", name)[:LONGEST_NAME].strip("._") or "_"


def _own(name: str, readable: str | None = None) -> str:
    """Give a plain name, of which no two are the same."""
    known = name if readable is None else readable
    plain = _plain(known)
    if plain == known:
        return plain
    told = name.encode(errors="backslashreplace")
    return f"{plain}-{hashlib.sha256(told).hexdigest()[:6]}"


def _as_named(path: Path, config: pytest.Config) -> str:
    """Name a file as one would where pytest was called."""
    here = config.invocation_params.dir
    return os.path.relpath(path, here) if path.is_relative_to(here) else str(path)


def _attach_to_html(config: pytest.Config, report: Any, name: str, path: Path) -> None:
    """Show a picture in the page that pytest-html writes, if it is there and asked for one.

    ``report.extras`` is that plug-in's own.
    """
    html = config.pluginmanager.getplugin("html")
    if html is None or not config.getoption("htmlpath", None) or not hasattr(html, "extras"):
        return
    content = base64.b64encode(path.read_bytes()).decode("ascii")
    report.extras = [*getattr(report, "extras", []), html.extras.png(content, name=name)]
