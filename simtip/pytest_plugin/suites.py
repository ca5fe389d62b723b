"""Cases of suites as tests have them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from simtip.errors import InputError
from simtip.regress.suite import STANDARD, Case, Suite, read_suite, standard_suite, sweep_of
from simtip.spec import SceneSpec
from simtip.sweep.assignment import Scenes
from simtip.sweep.plan import Plan


def case_of(suite: Suite, name: str) -> Case:
    """Find a case.

    Raises
    ------
    InputError
        There is none of that name; the remedy is the nearest.
    """
    found = {case.name: case for case in suite.cases}
    if name in found:
        return found[name]
    near = difflib.get_close_matches(name, found, n=1)
    remedy = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(found)}"
    raise InputError(f"the suite {suite.name!r} has no case {name!r}", remedy=remedy)


def plan_of(case: Case, repeats: int | None, seed: int | None) -> Plan:
    """Give a case's pairs as a sweep.

    Parameters
    ----------
    case
        The case.
    repeats, seed
        In place of its own; None leaves them.

    Raises
    ------
    InputError
        A field does not exist, or a value does not fit.
    """
    said = {"repeats": repeats, "seed": seed}
    spec = sweep_of(case, None).model_copy(
        update={name: value for name, value in said.items() if value is not None}
    )
    try:
        return Plan(spec, case.sweep.scene, name=case.sweep.document.file)
    except InputError as error:
        raise case.sweep.located(error) from error


@cache
def _standard() -> Suite:
    return read_suite(standard_suite())


def scene_of_case(name: str, changes: Mapping[str, Any]) -> SceneSpec:
    """Give the scene of a case of the standard suite.

    Parameters
    ----------
    name
        Of the case.
    changes
        Other fields of the scene; those that vary in the case have to be among them.

    Raises
    ------
    InputError
        There is no such case, or a field is missing or does not fit.
    """
    case = case_of(_standard(), name)
    spec = case.sweep.spec
    varied: dict[str, Any] = {**spec.factors}
    for group in spec.zipped:
        varied.update(group)
    for path in _missing(varied, changes):
        raise InputError(
            f"varies in the case {name!r} of the suite {STANDARD}",
            field=path,
            remedy=f"give it in changes, e.g. one of {varied[path]}; or take simtip_suite",
        )
    return Scenes(case.sweep.scene, case.sweep.scene.name).with_values({**spec.base, **changes})


def _missing(varied: Iterable[str], changes: Mapping[str, Any]) -> list[str]:
    return [path for path in varied if path not in changes]
