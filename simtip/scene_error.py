"""What is wrong with a scene file, in one line: the field, what it may be, the remedy."""

from __future__ import annotations

import difflib
import types
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from simtip.errors import InputError
from simtip.scene_range import allowed_range
from simtip.spec import SceneSpec
from simtip.yaml_file import Document, FieldPath, shown, undotted

if TYPE_CHECKING:
    from collections.abc import Sized

    from pydantic_core import ErrorDetails
    from typing_extensions import TypeIs

_BOUND_ERRORS = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}

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


def input_error(
    document: Document, error: ValidationError, within: tuple[str, ...] = ()
) -> InputError:
    """Turn pydantic's errors about a scene into one line.

    Parameters
    ----------
    document
        The file.
    error
        What pydantic found wrong in it.
    within
        The part of a scene that the file is, if it is no whole one.
    """
    found = error.errors(include_url=False)
    # A misspelled key also shows up as a missing one: the misspelling is what the user can see.
    first = min(found, key=lambda e: e["type"] != "extra_forbidden")
    where = (*within, *first["loc"])
    path, parent = _locate(where)
    problem, path, remedy = _explain(first, where, path, parent)
    path = path[len(within) :]
    if len(found) > 1:
        problem += f" (and {len(found) - 1} more)"
    return document.error(problem, path, remedy=remedy)


def _explain(
    error: ErrorDetails, where: tuple[int | str, ...], path: FieldPath, parent: object
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
        return _explain_refusal(context["error"], path)
    limits = allowed_range(where) if kind in _BOUND_ERRORS else None
    wanted = f"has to be {limits}" if limits else error["msg"].replace("Input should ", "has to ")
    return f"{wanted}, not {shown(value)}", path, "correct the value"


def _explain_refusal(error: ValueError, path: FieldPath) -> tuple[str, FieldPath, str | None]:
    """Explain what a check of the models refused; an InputError names the field within the part."""
    if isinstance(error, InputError):
        inner = undotted(error.field) if error.field else ()
        return error.problem, (*path, *inner), error.remedy
    return str(error), path, "correct it"


def _explain_length(
    path: FieldPath, value: Sized, context: dict[str, Any], parent: object
) -> tuple[str, FieldPath, str | None]:
    """Explain a missing key, or a list that is too short or too long."""
    if "max_length" in context:
        most = "at most " if Ellipsis in get_args(_inside(parent, path[-1])) else ""
        return f"has {len(value)} entries", path, f"give {most}{context['max_length']}"
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
