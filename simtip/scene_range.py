"""The range that a scene's number may lie in, in words, read off the model's JSON Schema."""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import BaseModel

from simtip.spec import SceneSpec

Schema = dict[str, Any]

_ENDS = {
    "minimum": "at least",
    "exclusiveMinimum": "above",
    "maximum": "at most",
    "exclusiveMaximum": "below",
}


def allowed_range(
    location: tuple[int | str, ...], model: type[BaseModel] = SceneSpec
) -> str | None:
    """Give the whole range of a number, such as "from 0 to 1" or "above 0 and below 90".

    Parameters
    ----------
    location
        Where pydantic found it: keys, indices, and the kinds of what comes in several kinds.
    model
        In which.

    Returns
    -------
    str or None
        None where the schema states no bounds.
    """
    whole = node = _schema(model)
    for part in location:
        inside = _inside(node, part, whole)
        if inside is None:
            return None
        node = inside
    return _in_words(_plain(node, whole))


@cache
def _schema(model: type[BaseModel]) -> Schema:
    return model.model_json_schema()


def _plain(node: Schema, whole: Schema) -> Schema:
    """Follow references into the whole schema, and leave out null."""
    while True:
        if "$ref" in node:
            node = whole["$defs"][node["$ref"].rsplit("/", 1)[-1]]
        elif "anyOf" in node:
            node = next(branch for branch in node["anyOf"] if branch.get("type") != "null")
        else:
            return node


def _inside(node: Schema, part: int | str, whole: Schema) -> Schema | None:
    """Give the schema of a key, an entry, or one kind of several."""
    node = _plain(node, whole)
    if isinstance(part, int):
        entries = node.get("prefixItems", [])
        inside: Schema | None = entries[part] if part < len(entries) else node.get("items")
        return inside
    if "discriminator" in node:
        kind = node["discriminator"]["mapping"].get(part)
        return None if kind is None else {"$ref": kind}
    found: Schema | None = node.get("properties", {}).get(part)
    return found


def _in_words(node: Schema) -> str | None:
    ends = [f"{word} {node[key]:g}" for key, word in _ENDS.items() if key in node]
    if {"minimum", "maximum"} <= node.keys():
        return f"from {node['minimum']:g} to {node['maximum']:g}"
    return " and ".join(ends) or None
