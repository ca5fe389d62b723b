"""Where results come from: the last section of every page."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from simtip.page.parts import Grid, Part, Section

MOST_FILES = 40


def origin(
    folder: Path,
    facts: Mapping[str, object],
    files: Iterable[str],
    more: Sequence[Part] = (),
) -> Section:
    """Give the section.

    Parameters
    ----------
    folder
        Of the results.
    facts
        By name; those that are None are left out.
    files
        Names of files that the page was made from.
    more
        Parts that stand behind.
    """
    rows = [[name, str(value)] for name, value in facts.items() if value is not None]
    named = list(files)
    hashes = [[name, sha256_of(folder / name)] for name in named[:MOST_FILES]]
    title = "SHA-256 of files"
    if len(named) > MOST_FILES:
        title += f", the first {MOST_FILES} of {len(named)}"
    parts: list[Part] = [Grid("Made with", ["what", "which"], rows)]
    if hashes:
        parts.append(Grid(title, ["file", "SHA-256"], hashes))
    return Section("provenance", "Provenance", [*parts, *more])


def versions(said: Mapping[str, Any]) -> dict[str, object]:
    """Give the versions that results depend on, as `simtip.provenance.environment` told them."""
    packages = said.get("packages")
    listed = packages if isinstance(packages, dict) else {}
    return {
        "simtip": said.get("simtip"),
        "Python": said.get("python"),
        "platform": said.get("platform"),
        "packages": ", ".join(f"{name} {v}" for name, v in listed.items() if v) or None,
    }


def sha256_of(file: Path) -> str:
    """Give a file's SHA-256, in hexadecimal, or what keeps it from being read."""
    digest = hashlib.sha256()
    if not file.is_file():  # a pipe would never end
        return "cannot be read"
    try:
        with file.open("rb") as stream:
            while chunk := stream.read(1 << 20):
                digest.update(chunk)
    except OSError:
        return "cannot be read"
    return digest.hexdigest()
