"""Which cases of which suite a test runs over: its marker, the command line, or all of standard."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from simtip.errors import InputError
from simtip.pytest_plugin.one_line import in_one_line
from simtip.pytest_plugin.options import chosen
from simtip.pytest_plugin.places import Places
from simtip.pytest_plugin.suites import case_of
from simtip.regress.suite import STANDARD, Case, Suite, read_suite, standard_suite

NAME = "simtip"
KNOWN = ("suite", "cases", "repeats")

SUITES: pytest.StashKey[dict[Path, Suite]] = pytest.StashKey()
"""Those that were read in this session."""


@dataclass(frozen=True)
class Selected:
    """A case, and how many pairs of each of its conditions; None are as many as it says."""

    suite: str
    case: Case
    repeats: int | None


def parametrize(metafunc: pytest.Metafunc) -> None:
    """Let a test run once a case; what is wrong is one line of the collection."""
    with in_one_line():
        selected = _selected(metafunc)
    metafunc.parametrize(
        "simtip_suite", selected, ids=[one.case.name for one in selected], indirect=True
    )


def _selected(metafunc: pytest.Metafunc) -> list[Selected]:
    said = _marked(metafunc.definition.iter_markers(NAME))
    suite = _suite(metafunc, said.get("suite"))
    names = said.get("cases")
    cases = suite.cases if names is None else tuple(case_of(suite, name) for name in names)
    return [Selected(suite.name, case, said.get("repeats")) for case in cases]


def _marked(markers: Iterable[pytest.Mark]) -> dict[str, Any]:
    """Put together what a test's markers say, those nearest to it first."""
    said: dict[str, Any] = {}
    for marker in markers:
        if marker.args:
            raise _wrong("takes names only", "write e.g. suite='standard'")
        for key, value in marker.kwargs.items():
            if key not in KNOWN:
                raise _wrong(f"knows no {key!r}", f"known: {', '.join(KNOWN)}")
            said.setdefault(key, value)
    _check(said)
    return said


def _check(said: dict[str, Any]) -> None:
    names, repeats = said.get("cases"), said.get("repeats")
    if isinstance(names, str):
        said["cases"] = names = [names]
    if names is not None and not (
        isinstance(names, list | tuple) and names and all(isinstance(one, str) for one in names)
    ):
        raise _wrong(f"has cases={names!r}", "give a list of names")
    whole = isinstance(repeats, int) and not isinstance(repeats, bool)
    if repeats is not None and not (whole and repeats >= 1):
        raise _wrong(f"has repeats={repeats!r}", "give a whole number from 1 on")


def _wrong(problem: str, remedy: str) -> InputError:
    return InputError(problem, field=f"@pytest.mark.{NAME}", remedy=remedy)


def _suite(metafunc: pytest.Metafunc, marked: object) -> Suite:
    """Read the suite once a session."""
    config = metafunc.config
    option = chosen(config, "--simtip-suite")
    if marked is not None:
        name, field = str(marked), f"@pytest.mark.{NAME}"
        places = Places.of(metafunc.definition, config)
    else:
        name, field = STANDARD if option is None else option, "--simtip-suite"
        places = Places(config.invocation_params.dir, config.rootpath)
    path = standard_suite() if name == STANDARD else places.find(name, "suite", field)
    read = config.stash.setdefault(SUITES, {})
    if path not in read:
        read[path] = read_suite(path)
    return read[path]
