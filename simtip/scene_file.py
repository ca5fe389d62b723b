"""Scene files: YAML in, `SceneSpec` out; errors name the line, the field and the remedy."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from pydantic import ValidationError

from simtip.scene_error import input_error
from simtip.spec import SceneSpec
from simtip.yaml_file import Document, FieldPath, Yaml, dump_yaml, load_yaml, shown, undotted

if TYPE_CHECKING:
    from simtip.errors import InputError

SCHEMA_DIALECT = "https://json-schema.org/draft/2020-12/schema"


@dataclass(frozen=True)
class SceneFile:
    """A scene together with the file it came from.

    Attributes
    ----------
    spec
        The checked scene.
    document
        The file's plain data and line numbers.
    """

    spec: SceneSpec
    document: Document

    def line_of(self, field: str) -> int | None:
        """Give the 1-based line of a field such as ``lamps[0].power``.

        A field that is left to its default has the line of the nearest part around it.
        """
        return self.document.line(undotted(field))

    def error(self, problem: str, field: str, *, remedy: str | None = None) -> InputError:
        """Make the error that names this file, the field and its line.

        Parameters
        ----------
        problem
            What is wrong.
        field
            Dotted path, e.g. ``detect.threshold``.
        remedy
            What to do about it.
        """
        return self.document.error(problem, undotted(field), remedy=remedy)


def load_scene(path: str | Path) -> SceneSpec:
    """Read and check a scene file.

    Parameters
    ----------
    path
        A YAML file, see `scene_schema`. A top-level ``$schema`` is ignored.

    Raises
    ------
    InputError
        Whatever is wrong first, with its line and dotted field. Types are strict: ``"5"`` and
        ``true`` are no numbers, ``5`` is no text, ``5.0`` is no whole number.
    """
    return read_scene(path).spec


def read_scene(path: str | Path) -> SceneFile:
    """Read and check a scene file, and keep its line numbers for later messages.

    Parameters and errors are those of `load_scene`.
    """
    document = load_yaml(path)
    if not isinstance(document.value, dict):
        raise document.error(
            f"a scene is a mapping of keys, not {shown(document.value)}",
            remedy="start from a file in scenes/",
        )
    data = {key: value for key, value in document.value.items() if key != "$schema"}
    _refuse_infinite(document, data, ())
    try:
        # From JSON, strict mode takes a list for a tuple and nothing else for anything else.
        spec = SceneSpec.model_validate_json(json.dumps(data, allow_nan=False), strict=True)
    except ValidationError as error:
        raise input_error(document, error) from None
    except ArithmeticError as error:  # from a check in the models, which pydantic lets through
        raise document.error(
            f"has a value beyond arithmetic ({error})", remedy="look for a tiny or huge number"
        ) from error
    return SceneFile(_beside(Path(path), spec), document)


def _beside(path: Path, spec: SceneSpec) -> SceneSpec:
    """Let the file that a scene names count from the scene's folder."""
    if spec.rig.measured is None:
        return spec
    measured = str(path.absolute().parent / spec.rig.measured)
    return spec.model_copy(update={"rig": spec.rig.model_copy(update={"measured": measured})})


def dump_scene(spec: SceneSpec) -> str:
    """Write a scene as YAML with every default spelled out; `load_scene` reads an equal one."""
    return dump_yaml(cast("Yaml", json.loads(spec.model_dump_json())))


def scene_schema() -> dict[str, Any]:
    """Give the JSON Schema of a scene file, for completion and checks in editors."""
    schema = SceneSpec.model_json_schema()
    schema["properties"] = {
        "$schema": {"type": "string", "description": "Where this schema is; ignored by simtip."},
        **schema["properties"],
    }
    return {
        "$schema": SCHEMA_DIALECT,
        **schema,
        "title": "simtip scene",
        "description": (
            "A titanium needle seen by a stereo rig, its light, and how it is measured. World "
            "frame = left camera frame: x right, y down, z forward. Lengths in mm, times in s; "
            "pixel (0, 0) is the centre of the top-left pixel."
        ),
    }


def _refuse_infinite(document: Document, value: Yaml, path: FieldPath) -> None:
    if isinstance(value, dict):
        for key, child in value.items():
            _refuse_infinite(document, child, (*path, key))
    elif isinstance(value, list):
        for index, child in enumerate(value):
            _refuse_infinite(document, child, (*path, index))
    elif isinstance(value, float) and not math.isfinite(value):
        raise document.error(f"{value} is not a finite number", path, remedy="write a number")
