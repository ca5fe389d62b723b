"""The range that a scene's number may lie in, in words, read off the scene's JSON Schema."""

from __future__ import annotations

from functools import cache
from typing import Any

from simtip.spec import SceneSpec

Schema = dict[str, Any]

_ENDS = {
    "minimum": "at least",
    "exclusiveMinimum": "above",
    "maximum": "at most",
    "exclusiveMaximum": "below",
}


def allowed_range(location: tuple[int | str, ...]) -> str | None:
    """Give the whole range of a number, such as "from 0 to 1" or "above 0 and below 90".

    Parameters
    ----------
    location
        Where pydantic found it: keys, indices, and the kinds of what comes in several kinds.

    Returns
    -------
    str or None
        None where the schema states no bounds.
    """
    node = _schema()
    for part in location:
        inside = _inside(node, part)
        if inside is None:
            return None
        node = inside
    return _in_words(_plain(node))


@cache
def _schema() -> Schema:
    return SceneSpec.model_json_schema()


def _plain(node: Schema) -> Schema:
    """Follow references, and leave out null."""
    while True:
        if "$ref" in node:
            node = _schema()["$defs"][node["$ref"].rsplit("/", 1)[-1]]
        elif "anyOf" in node:
            node = next(branch for branch in node["anyOf"] if branch.get("type") != "null")
        else:
            return node


def _inside(node: Schema, part: int | str) -> Schema | None:
    """Give the schema of a key, an entry, or one kind of several."""
    node = _plain(node)
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
