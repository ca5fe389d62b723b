"""Light groups with all that is needed to go on from them, written and read."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simtip.errors import InputError
from simtip.light_file.exr import UNREADABLE, Part, read_heads, read_parts, write_parts
from simtip.light_file.heading import ATTRIBUTE, FORMAT, REMEDY, checksums, parse
from simtip.light_file.layers import to_parts, to_view
from simtip.render.backend import VARIANTS
from simtip.render.view import View
from simtip.spec import SceneSpec
from simtip.version import __version__


@dataclass(frozen=True, eq=False)
class Lights:
    """One view's light groups and where they came from.

    Attributes
    ----------
    view
        As it was rendered.
    spec
        The scene it was rendered from.
    seed
        The root seed it was rendered with.
    side
        "left" or "right".
    """

    view: View
    spec: SceneSpec
    seed: int
    side: str


def lights_name(side: str) -> str:
    """Name a view's file in a folder of results."""
    return f"{side}_lights.exr"


def write_lights(path: Path, lights: Lights) -> None:
    """Write a view's light groups.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    parts = to_parts(lights.view)
    about = {
        "format": FORMAT,
        "version": __version__,
        "side": lights.side,
        "seed": lights.seed,
        "backend": lights.view.backend,
        "lamps": list(lights.view.lamps),
        "scene": lights.spec.model_dump(mode="json"),
        "crc32": checksums(parts),
    }
    comments = "radiance per unit radiance of each lamp; Z: camera z, mm"
    write_parts(path, parts, {"comments": comments, ATTRIBUTE: json.dumps(about)})


def read_lights(path: Path) -> Lights:
    """Read a view's light groups.

    Raises
    ------
    InputError
        The file is missing, is no such file, or is damaged.
    """
    if not path.is_file():
        raise InputError("no such file", file=path, remedy=REMEDY)
    try:
        heads = read_heads(path)
        about = parse(heads)
        parts = read_parts(path, heads)
    except InputError as error:
        raise InputError(error.problem, file=path, remedy=error.remedy) from error
    except UNREADABLE as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"is no readable OpenEXR file ({reason})", file=path, remedy=REMEDY
        ) from error
    try:
        return _lights(parts, about)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        what = str(error).splitlines()[0]
        raise InputError(
            f"is damaged or of another version ({what})", file=path, remedy=REMEDY
        ) from error


def _lights(parts: dict[str, Part], about: dict[str, Any]) -> Lights:
    if about["backend"] not in VARIANTS.values():
        raise ValueError(f"the back end {about['backend']!r} is unknown")
    spec = SceneSpec.model_validate_json(json.dumps(about["scene"]), strict=True)
    lamps = [str(name) for name in about["lamps"]]
    view = to_view(parts, lamps, str(about["backend"]))
    written = dict(about["crc32"])
    changed = [name for name, crc in checksums(parts).items() if written.get(name) != crc]
    if changed:
        raise ValueError(f"channel {changed[0]} is not as it was written")
    return Lights(view, spec, int(about["seed"]), str(about["side"]))
