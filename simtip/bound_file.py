"""Bounds read back from what ``simtip bound`` wrote, checked as any other data."""

from __future__ import annotations

import math
import re
from pathlib import Path

from simtip.bound import KnownBound
from simtip.bound.inputs import PARTS
from simtip.errors import InputError
from simtip.input_file import read_bytes
from simtip.rig_file.json_document import parse_json
from simtip.yaml_file import Document, FieldPath, Yaml, shown

MAX_BYTES = 1 << 20

KEYS = frozenset(
    (
        *("scene", "seed", "backend", "inputs_sha256"),
        *("bound_mm", "bound_known_mm", "bound_axis_mm", "bound_axis_known_mm"),
        *("bound_px", "bound_known_px", "nuisances", "without_effect"),
        *("step_px", "step_mm", "samples", "replicas", "convergence", "timings_s"),
    )
)
"""Of what ``simtip bound --json`` prints."""

ONLY_IN_FOLDERS = frozenset({"environment"})

AXES = ("x", "y", "z")

NORM_TOLERANCE = 1e-6
"""How far the norm may be from that of x, y and z, relative."""

REMEDY = "give what `simtip bound SCENE --json` prints, or its folder's bound.json"


def read_bound(path: str | Path) -> KnownBound:
    """Read the bound that ``simtip bound`` printed, or wrote into its folder.

    Parameters
    ----------
    path
        A JSON file.

    Raises
    ------
    InputError
        The file cannot be read, is no JSON or no bound: keys are missing or unknown, or a number is
        not finite or not above 0.
    """
    document = parse_json(read_bytes(path, MAX_BYTES), path)
    value = _mapping(document, (), document.value, KEYS, ONLY_IN_FOLDERS)
    norm_mm = _norm(document, value["bound_mm"])
    return KnownBound(norm_mm, _digests(document, value["inputs_sha256"]), document.file)


def _mapping(
    document: Document,
    path: FieldPath,
    value: Yaml,
    keys: frozenset[str],
    optional: frozenset[str] = frozenset(),
) -> dict[str, Yaml]:
    """Give a value that is a mapping of these keys and no others."""
    if not isinstance(value, dict):
        raise _error(document, f"has to be a mapping of keys, not {shown(value)}", path)
    for key in sorted(keys - set(value)):
        raise _error(document, "is missing", (*path, key))
    for key in sorted(set(value) - keys - optional):
        raise _error(document, "unknown key", (*path, key))
    return value


def _norm(document: Document, value: Yaml) -> float | None:
    """Give the norm, mm, once it agrees with x, y and z."""
    path = ("bound_mm",)
    place = _mapping(document, path, value, frozenset((*AXES, "norm")))
    numbers = {key: _deviation(document, (*path, key), place[key]) for key in (*AXES, "norm")}
    norm = numbers["norm"]
    parts = [numbers[axis] for axis in AXES]
    known = [part for part in parts if part is not None]
    expected = math.hypot(*known) if len(known) == len(parts) else None
    agrees = (
        norm == expected
        if norm is None or expected is None
        else math.isclose(norm, expected, rel_tol=NORM_TOLERANCE)
    )
    if not agrees:
        raise _error(
            document,
            f"has to be the norm of x, y and z, {shown(expected)}, not {shown(norm)}",
            (*path, "norm"),
        )
    return norm


def _deviation(document: Document, path: FieldPath, value: Yaml) -> float | None:
    """Give a standard deviation: finite and above 0, or None for what is not determined."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0:
        raise _error(document, f"has to be a number above 0, or null, not {shown(value)}", path)
    return float(value)


def _digests(document: Document, value: Yaml) -> dict[str, str]:
    path = ("inputs_sha256",)
    found: dict[str, str] = {}
    for part, digest in _mapping(document, path, value, frozenset(PARTS)).items():
        if not (isinstance(digest, str) and re.fullmatch(r"[0-9a-f]{64}", digest)):
            raise _error(document, f"is no SHA-256, but {shown(digest)}", (*path, part))
        found[part] = digest
    return found


def _error(document: Document, problem: str, path: FieldPath) -> InputError:
    return document.error(problem, path, remedy=REMEDY)
