"""Scene files: YAML in, `SceneSpec` out; errors name the line, the field and the remedy."""

from __future__ import annotations

import difflib
import json
import math
import types
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, cast, get_args, get_origin

from pydantic import BaseModel, ValidationError

from simtip.spec import SceneSpec
from simtip.yaml_file import Document, FieldPath, Yaml, dump_yaml, load_yaml, shown, undotted

if TYPE_CHECKING:
    from collections.abc import Sized
    from pathlib import Path

    from pydantic_core import ErrorDetails
    from typing_extensions import TypeIs

    from simtip.errors import InputError

SCHEMA_DIALECT = "https://json-schema.org/draft/2020-12/schema"

_WANTED = {
    "bool_type": "true or false",
    "dict_type": "a mapping of keys",
    "float_type": "a number",
    "int_type": "a whole number, without a decimal point",
    "list_type": "a list",
    "model_type": "a mapping of keys",
    "string_type": "text",
    "tuple_type": "a list",
}
"""What pydantic's error types ask for, in the words of a YAML file."""


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
        raise _input_error(document, error) from None
    except ArithmeticError as error:  # from a check in the models, which pydantic lets through
        raise document.error(
            f"has a value beyond arithmetic ({error})", remedy="look for a tiny or huge number"
        ) from error
    return SceneFile(spec, document)


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


def _input_error(document: Document, error: ValidationError) -> InputError:
    """Turn pydantic's list of errors into one line."""
    found = error.errors(include_url=False)
    # A misspelled key also shows up as a missing one: the misspelling is what the user can see.
    first = min(found, key=lambda e: e["type"] != "extra_forbidden")
    path, parent = _locate(first["loc"])
    problem, path, remedy = _explain(first, path, parent)
    if len(found) > 1:
        problem += f" (and {len(found) - 1} more)"
    return document.error(problem, path, remedy=remedy)


def _explain(
    error: ErrorDetails, path: FieldPath, parent: object
) -> tuple[str, FieldPath, str | None]:
    """Give the problem, the path to name and the remedy."""
    kind, value, context = error["type"], error["input"], error.get("ctx", {})
    if kind == "extra_forbidden":
        return "unknown key", path, _nearest_key(str(path[-1]), parent)
    if kind in {"missing", "too_long"}:
        return _explain_length(path, value, context, parent)
    if kind.startswith("union_tag"):
        return _explain_tag(path, value, context)
    if kind in _WANTED:
        return f"has to be {_WANTED[kind]}, not {shown(value)}", path, _type_remedy(kind, value)
    if kind == "value_error":
        return str(context["error"]), path, "correct it"
    wanted = error["msg"].replace("Input should ", "has to ")
    return f"{wanted}, not {shown(value)}", path, "correct the value"


def _explain_length(
    path: FieldPath, value: Sized, context: dict[str, Any], parent: object
) -> tuple[str, FieldPath, str | None]:
    """Explain a missing key, or a list that is too short or too long."""
    if "max_length" in context:
        return f"has {len(value)} entries", path, f"give {context['max_length']}"
    if isinstance(path[-1], int):
        return f"has {len(value)} entries", path[:-1], f"give {len(get_args(parent))}"
    return "is missing", path, "add it"


def _explain_tag(
    path: FieldPath, value: object, context: dict[str, Any]
) -> tuple[str, FieldPath, str | None]:
    """Explain a mapping whose ``kind`` is missing or unknown."""
    key = str(context["discriminator"]).strip("'")
    if "tag" not in context:
        return "is missing", (*path, key), "say which kind it is"
    given = value.get(key) if isinstance(value, dict) else value
    expected = str(context["expected_tags"]).replace(", ", " or ")
    return f"has to be {expected}, not {shown(given)}", (*path, key), "choose one"


def _type_remedy(kind: str, value: object) -> str:
    if kind in {"float_type", "int_type", "bool_type"} and isinstance(value, str):
        return "write it without quotes or units"
    if kind == "string_type":
        return "put it in quotes"
    return "correct the value"


def _nearest_key(key: str, parent: object) -> str:
    fields = parent.model_fields if _is_model(parent) else {}
    near = difflib.get_close_matches(key, fields, n=1)
    if near:
        return f"did you mean '{near[0]}'?"
    return f"known keys: {', '.join(fields)}"


def _locate(location: tuple[int | str, ...]) -> tuple[FieldPath, object]:
    """Follow pydantic's location through the models.

    Returns
    -------
    path
        The location without the names that pydantic puts in for the branches of a union.
    parent
        The type that holds the last part of the path.
    """
    here: object = SceneSpec
    parent: object = None
    path: FieldPath = ()
    for part in location:
        branches = _branches(here)
        if len(branches) > 1:
            here = next((b for b in branches if _is_branch(b, part)), None)
            continue
        parent = branches[0] if branches else None
        here = _inside(parent, part)
        path = (*path, part)
    return path, parent


def _branches(annotation: object) -> list[object]:
    """Give the types that an annotation allows, without null."""
    if get_origin(annotation) is Annotated:
        return _branches(get_args(annotation)[0])
    if get_origin(annotation) in {Union, types.UnionType}:
        return [a for a in get_args(annotation) if a is not type(None)]
    return [annotation]


def _is_branch(branch: object, name: int | str) -> bool:
    """Say whether pydantic calls this branch of a union by that name: its ``kind``."""
    if not _is_model(branch):
        return False
    literals = [f.annotation for f in branch.model_fields.values()]
    return any(get_origin(a) is Literal and name in get_args(a) for a in literals)


def _inside(annotation: object, part: int | str) -> object:
    """Give the type of a key of a model or an entry of a tuple or list, if known."""
    if _is_model(annotation):
        field = annotation.model_fields.get(str(part))
        return None if field is None else field.annotation
    entries = [a for a in get_args(annotation) if a is not Ellipsis]
    if isinstance(part, int) and entries:
        return entries[min(part, len(entries) - 1)]
    return None


def _is_model(annotation: object) -> TypeIs[type[BaseModel]]:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)
