"""Sweep files: YAML in, a checked sweep and its scene out."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from simtip.detect.parameters import FIELD_PREFIX
from simtip.errors import InputError
from simtip.scene_file import SceneFile, read_scene
from simtip.spec import SceneSpec
from simtip.sweep.spec import MEASURED, SweepSpec
from simtip.yaml_file import Document, FieldPath, dotted, load_yaml, shown, undotted

REMEDY = "see docs/sweeps.md, or start from a file in scenes/sweeps/"


@dataclass(frozen=True)
class SweepFile:
    """A sweep together with the file it came from, and its scene.

    Attributes
    ----------
    spec
        The sweep.
    scene_file
        The scene it names, with its own file.
    document
        The file's plain data and line numbers.
    at
        Where in the document the sweep stands; () is all of it.
    """

    spec: SweepSpec
    scene_file: SceneFile
    document: Document
    at: FieldPath = ()

    @property
    def scene(self) -> SceneSpec:
        """The scene it names, as it is in its file."""
        return self.scene_file.spec

    def located(self, error: InputError) -> InputError:
        """Give an error about a field the line that says it, in the sweep's file or its scene's."""
        if error.file is not None or error.field is None:
            return error
        place = place_of(_part(self.document, self.at), error.field)
        if place is None and error.field.startswith(f"{FIELD_PREFIX}."):
            return self.scene_file.error(error.problem, error.field, remedy=error.remedy)
        return InputError(
            error.problem,
            file=self.document.file,
            line=self.document.line((*self.at, *(place or ("base",)))),
            field=error.field,
            remedy=error.remedy,
        )


def place_of(data: Any, field: str) -> FieldPath | None:
    """Find where a sweep's data gives a field, a part around it, or else a part of it.

    Parameters
    ----------
    data
        Of a sweep's file, whatever it holds.
    field
        Of the scene, such as ``lamps[0].power``; or of the sweep, such as ``zipped[0]``.
    """
    path = undotted(field)
    given = {place: undotted(str(place[-1])) for place in _varied(data)}
    same = [place for place in given if field in (place[-1], dotted(place), repr(place[-1]))]
    around = [place for place, whole in given.items() if whole and path[: len(whole)] == whole]
    within = [place for place, part in given.items() if part[: len(path)] == path]
    for found in (same, sorted(around, key=lambda place: -len(given[place])), within):
        if found:
            return found[0]
    return path if path and path[0] in SweepSpec.model_fields else None


def _varied(data: Any) -> Iterator[FieldPath]:
    """Give the places where a sweep's data names fields of the scene."""
    said = data if isinstance(data, dict) else {}
    parts: dict[FieldPath, Any] = {(name,): said.get(name) for name in ("factors", "base")}
    groups = said.get("zipped")
    for number, group in enumerate(groups if isinstance(groups, list) else ()):
        parts["zipped", number] = group
    for place, names in parts.items():
        for name in names if isinstance(names, dict) else ():
            yield (*place, name)


def read_sweep(path: str | Path) -> SweepFile:
    """Read and check a sweep file and its scene.

    Raises
    ------
    InputError
        Whatever is wrong first, with its line and dotted field.
    """
    document = load_yaml(path)
    if not isinstance(document.value, dict):
        raise document.error(
            f"a sweep is a mapping of keys, not {shown(document.value)}", remedy=REMEDY
        )
    data = {key: value for key, value in document.value.items() if key != "$schema"}
    return sweep_within(document, data, Path(path).absolute().parent)


def sweep_within(
    document: Document, data: dict[str, Any], folder: Path, at: FieldPath = ()
) -> SweepFile:
    """Check a sweep that stands in a document, and read its scene.

    Parameters
    ----------
    document
        That it stands in.
    data
        What a sweep's file would hold.
    folder
        From which the files that it names count.
    at
        Where in the document it stands.

    Raises
    ------
    InputError
        Whatever is wrong first, with its line and dotted field.
    """
    try:
        spec = SweepSpec.model_validate_json(json.dumps(data, allow_nan=False), strict=True)
    except ValidationError as error:
        raise _said(document, error, at) from None
    except ValueError as error:
        place = next(_not_finite(data, ()), ())
        raise document.error(
            "is no number", (*at, *place), remedy="give a finite number"
        ) from error
    return SweepFile(_beside(folder, spec), read_scene(folder / spec.scene), document, at)


def _not_finite(value: Any, path: FieldPath) -> Iterator[FieldPath]:
    """Find numbers that are none."""
    if isinstance(value, float) and not math.isfinite(value):
        yield path
    parts = value.items() if isinstance(value, dict) else ()
    for key, part in enumerate(value) if isinstance(value, list) else parts:
        yield from _not_finite(part, (*path, key))


def _beside(folder: Path, spec: SweepSpec) -> SweepSpec:
    """Let the rigs that a sweep file names count from its folder, as its scene does."""

    def whole(path: object) -> object:
        return str(folder / path) if isinstance(path, str) else path

    def all_whole(levels: object) -> object:
        return [whole(level) for level in levels] if isinstance(levels, list) else levels

    base = {name: whole(v) if name == MEASURED else v for name, v in spec.base.items()}
    factors = {name: all_whole(v) if name == MEASURED else v for name, v in spec.factors.items()}
    zipped = [
        {name: all_whole(v) if name == MEASURED else v for name, v in group.items()}
        for group in spec.zipped
    ]
    return spec.model_copy(update={"base": base, "factors": factors, "zipped": zipped})


def _part(document: Document, at: FieldPath) -> Any:
    value: Any = document.value
    for key in at:
        value = value[key]
    return value


def _said(document: Document, error: ValidationError, at: FieldPath) -> InputError:
    found = error.errors(include_url=False)
    first = min(found, key=_oddness)
    path = tuple(part for part in first["loc"] if not _is_branch(part))
    refusal = first.get("ctx", {}).get("error")
    if isinstance(refusal, InputError):
        inner = undotted(refusal.field) if refusal.field else ()
        place = None if path else place_of(_part(document, at), refusal.field or "")
        place = place or (*path, *inner)
        return document.error(refusal.problem, (*at, *place), remedy=refusal.remedy)
    said = {"extra_forbidden": "is no key of a sweep", "missing": "is missing"}
    problem = said.get(first["type"]) or first["msg"].replace("Input should ", "has to ")
    if first["type"] not in said:
        problem += f", not {shown(first['input'])}"
    return document.error(_lower(problem), (*at, *path), remedy=_remedy(path))


def _oddness(error: Any) -> int:
    """Rank errors: of a value that fits no branch of several, one says what is wrong."""
    if error["type"] == "extra_forbidden":
        return 0
    return 2 if error["type"] in NOT_THIS_BRANCH else 1


def _is_branch(part: int | str) -> bool:
    """Say whether a part of a location names a branch of a union, or a check."""
    return part in BRANCHES or str(part).startswith(("function-", "constrained-"))


NOT_THIS_BRANCH = {"model_type", "model_attributes_type", "list_type", "string_type"}

BRANCHES = {"RangeSpec", "list[any]", "constrained-list", "grid", "random", "sobol"} | {
    "latin_hypercube",
    "str",
    "DetectorEntry",
}
"""Names that pydantic puts in for the branches of a union."""


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]


def _remedy(path: FieldPath) -> str:
    if path[:1] == ("factors",) and len(path) > 1:
        return "give a list of values, or {from: 1, to: 10, count: 5} (or step, or log: true)"
    if len(path) == 1:
        return f"known keys: {', '.join(SweepSpec.model_fields)}"
    return f"correct {dotted(path)}; {REMEDY}"
