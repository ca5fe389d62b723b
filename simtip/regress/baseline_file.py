"""Baselines on disk: YAML (or JSON) for review, read strictly, with a checksum over the content."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from simtip.errors import InputError
from simtip.output_folder import write_atomically
from simtip.regress.baseline import FORMAT, MOST_NUMBERS, VERSION, Baseline
from simtip.sweep.stage_keys import digest_of
from simtip.yaml_file import Document, dump_yaml, load_yaml, shown

MAX_BYTES = 4 << 20

ENDINGS = (".yaml", ".yml", ".json")

CHECKSUM = "checksum"

RESTORE = "restore the file, or record it anew"


def read_baseline(path: Path) -> Baseline:
    """Read and check a baseline.

    Raises
    ------
    InputError
        It is no baseline, of another version, cut short, or was edited by hand.
    """
    document = load_yaml(path, MAX_BYTES)
    data = document.value
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise document.error(
            "is no baseline", remedy="give the file that `simtip regress record` wrote"
        )
    version = data.get("version")
    if isinstance(version, bool) or version != VERSION:
        raise document.error(
            f"the baseline's format is version {_brief(version)}, and this simtip reads {VERSION}",
            ("version",),
            remedy="use the simtip that wrote it, or record it anew",
        )
    told = data.pop(CHECKSUM, None)
    if told is None:
        raise document.error("is missing: the file was cut short", (CHECKSUM,), remedy=RESTORE)
    found = _validated(document, data)
    if told != _checksum(data):
        raise document.error(
            "does not fit the content: the file was edited",
            (CHECKSUM,),
            remedy=f"{RESTORE}; `simtip regress update` accepts changes",
        )
    return found


def write_baseline(path: Path, baseline: Baseline) -> None:
    """Write a baseline, whole or not at all.

    Raises
    ------
    InputError
        It is too large to be reviewed, or cannot be written.
    """
    numbers = 4 * sum(len(one.found) for case in baseline.cases for one in case.conditions)
    if numbers > MOST_NUMBERS:
        raise InputError(
            f"the suite has {numbers // 4} pairs of images, more than {MOST_NUMBERS // 4}",
            file=path,
            remedy="give fewer repeats or cases: a baseline is there to be reviewed",
        )
    data = baseline.model_dump(mode="json", exclude_defaults=False)
    for case in data["cases"]:
        if case["made_with"] is None:
            del case["made_with"]
    data = {**data, CHECKSUM: _checksum(data)}
    text = json.dumps(data, indent=1) + "\n" if path.suffix == ".json" else dump_yaml(data)
    write_atomically(path, text.encode())


def _checksum(data: dict[str, Any]) -> str:
    return digest_of(data)


def _validated(document: Document, data: dict[str, Any]) -> Baseline:
    try:
        text = json.dumps(data, allow_nan=False)
    except ValueError as error:
        raise document.error("holds a number that is none", remedy=RESTORE) from error
    try:
        return Baseline.model_validate_json(text, strict=True)
    except ValidationError as error:
        found = error.errors(include_url=False)
        first = min(found, key=lambda one: one["type"] != "extra_forbidden")
        place = tuple(part for part in first["loc"] if part not in ("float", "constrained-float"))
        said = {"extra_forbidden": "is no key of a baseline", "missing": "is missing"}
        problem = said.get(first["type"]) or first["msg"].replace("Input should ", "has to ")
        if first["type"] not in (*said, "value_error"):
            problem += f", not {shown(first['input'])}"
        problem = problem.removeprefix("Value error, ")
        raise document.error(problem[:1].lower() + problem[1:], place, remedy=RESTORE) from None


def _brief(version: Any) -> str:
    return shown(version)[:60]
