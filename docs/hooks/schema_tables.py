"""A JSON Schema as a page of Markdown: a table for each mapping."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

Schema = dict[str, Any]

MANY = 12
"""Lists of so many words and more are cut."""


def schema_page(title: str, opening: str, schema: Schema) -> str:
    """Write the page.

    Parameters
    ----------
    title, opening
        Its heading and first paragraph.
    schema
        As pydantic writes it: mappings under ``$defs``, referred to by name.
    """
    parts = schema.get("$defs", {})
    sections = [section("At the top", schema)]
    for name, places in where_used(schema).items():
        sections.append(section(f"{', '.join(places)} {{: #{name.lower()} }}", parts[name]))
    return f"# {title}\n\n{opening}\n\n" + "\n\n".join(sections) + "\n"


def where_used(schema: Schema) -> dict[str, list[str]]:
    """Give the places, as dotted keys, of every mapping that has a name, in the file's order."""
    places: dict[str, list[str]] = {}

    def walk(part: Schema, place: str) -> None:
        for key, field in part.get("properties", {}).items():
            for name in referred(field):
                target = schema["$defs"][name]
                variant = target["properties"].get("kind", {}).get("const")
                at = f"{place}{key}" + (f": {variant}" if variant else "")
                if at not in places.setdefault(name, []):
                    places[name].append(at)
                walk(target, f"{place}{key}.")

    walk(schema, "")
    return places


def referred(field: Any) -> Iterator[str]:
    """Give the names of all mappings that a field refers to, in alternatives and lists, too."""
    if isinstance(field, dict):
        if "$ref" in field:
            yield field["$ref"].rsplit("/", 1)[1]
        for key in ("anyOf", "oneOf", "items", "prefixItems", "additionalProperties"):
            yield from referred(field.get(key))
    elif isinstance(field, list):
        for one in field:
            yield from referred(one)


def section(heading: str, part: Schema) -> str:
    """Write one mapping: what it is, and its keys."""
    required = part.get("required", [])
    rows = [
        f"| `{key}` | {kind(field)} | {default(field, key in required)} "
        f"| {cell(field.get('description', ''))} |"
        for key, field in part.get("properties", {}).items()
        if key != "$schema"
    ]
    head = ["| key | value | default | |", "| --- | --- | --- | --- |"]
    about = "" if "$defs" in part else cell(part.get("description", "").split("\n\n")[0])
    return "\n\n".join(filter(None, [f"## {heading}", about, "\n".join([*head, *rows])]))


def kind(field: Schema) -> str:
    """Say in words what a value may be."""
    return ", or ".join(dict.fromkeys(kinds(field)))


def kinds(field: Schema) -> Iterator[str]:
    """Give every kind of value that is allowed."""
    alternatives = field.get("anyOf") or field.get("oneOf")
    if alternatives:
        for one in alternatives:
            yield from kinds(one)
    elif "$ref" in field:
        name = field["$ref"].rsplit("/", 1)[1]
        yield f"[mapping](#{name.lower()})"
    elif "const" in field:
        yield f"`{field['const']}`"
    elif "enum" in field:
        words = [f"`{word}`" for word in field["enum"]]
        yield " ".join(words[:MANY]) + (" .." if len(words) > MANY else "")
    else:
        yield plain(field)


def plain(field: Schema) -> str:
    """Say what a value without alternatives may be."""
    names = {"object": "mapping", "array": "list", "boolean": "true or false"}
    name = names.get(field.get("type", ""), field.get("type", "anything"))
    if name == "list":
        of = field.get("items") or (field.get("prefixItems") or [{}])[0]
        least, most = field.get("minItems"), field.get("maxItems")
        count = f"{most} " if most is not None and least == most else ""
        return f"list of {count}({kind(of)})"
    low, high = field.get("minimum"), field.get("maximum")
    least = f" from {low:g}" if low is not None and low > -1e6 else ""
    most = f" to {high:g}" if high is not None and high < 1e6 else ""
    return f"{name}{least}{most}"


def default(field: Schema, required: bool) -> str:
    """Give the default, where it is short."""
    if required:
        return "**required**"
    if "default" not in field:
        return ""
    if isinstance(field["default"], dict):
        return "its defaults"
    return f"`{json.dumps(field['default'])}`"


def cell(text: str) -> str:
    """Make text safe within a cell of a table."""
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")
