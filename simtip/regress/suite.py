"""Suites: named scenes and sweeps on which a detector is tried again and again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from simtip.regress.tolerance import Tolerance
from simtip.sweep.spec import SweepSpec
from simtip.sweep.sweep_file import SweepFile, read_sweep, sweep_within
from simtip.yaml_file import Document, FieldPath, load_yaml, shown

STANDARD = "standard"
"""Name of the suite that comes with simtip."""

USUAL_REPEATS = 12

_FOLDER = Path(__file__).resolve().parent
_REMEDY = "see docs/regress.md"


class SuiteSpec(BaseModel):
    """What a suite file says.

    A case is a mapping with a ``name`` and the keys of a sweep (``scene``, ``base``, ``factors``,
    ``zipped``, ``repeats``, ``seed``), or with the ``sweep`` file that has them.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: Annotated[str, Field(min_length=1, max_length=100)]
    about: Annotated[str, Field(max_length=1000, description="What it is for.")] = ""
    scene: Annotated[
        str | None, Field(description="Of cases that name none; counts from the suite's folder.")
    ] = None
    repeats: Annotated[
        int, Field(ge=2, le=10_000, description="Of cases that say none, each with new noise.")
    ] = USUAL_REPEATS
    tolerance: Annotated[Tolerance, Field(description="What is small enough to be left alone.")] = (
        Tolerance()
    )
    cases: Annotated[list[dict[str, Any]], Field(min_length=1, max_length=1000)]


@dataclass(frozen=True)
class Case:
    """One case of a suite.

    Attributes
    ----------
    name
        Unique in its suite.
    sweep
        The case as a sweep without detectors, with its scene and its place in the suite's file.
    """

    name: str
    sweep: SweepFile


@dataclass(frozen=True)
class Suite:
    """A suite and its file.

    Attributes
    ----------
    spec
        What the file says.
    cases
        In its order.
    document
        The file's plain data and line numbers.
    """

    spec: SuiteSpec
    cases: tuple[Case, ...]
    document: Document

    @property
    def name(self) -> str:
        """The suite's name."""
        return self.spec.name


def standard_suite() -> Path:
    """Give the file of the suite that comes with simtip."""
    return _FOLDER / STANDARD / "suite.yaml"


def read_suite(reference: str | Path) -> Suite:
    """Read and check a suite with all its scenes.

    Parameters
    ----------
    reference
        A file; or "standard", the suite that comes with simtip, where there is no such file.

    Raises
    ------
    InputError
        Whatever is wrong first, with its line and field.
    """
    path = Path(reference)
    if str(reference) == STANDARD and not path.exists():
        path = standard_suite()
    document = load_yaml(path)
    if not isinstance(document.value, dict):
        raise document.error(
            f"a suite is a mapping of keys, not {shown(document.value)}", remedy=_REMEDY
        )
    data = {key: value for key, value in document.value.items() if key != "$schema"}
    spec = _checked(document, lambda: SuiteSpec.model_validate(data, strict=True))
    folder = path.absolute().parent
    cases = tuple(_case(document, spec, folder, place) for place in range(len(spec.cases)))
    counts = Counter(case.name for case in cases)
    for place, case in enumerate(cases):
        if counts[case.name] > 1:
            raise document.error(
                f"{case.name!r} is the name of {counts[case.name]} cases",
                ("cases", place, "name"),
                remedy="give each a name of its own",
            )
    return Suite(spec, cases, document)


_NAME: TypeAdapter[str] = TypeAdapter(
    Annotated[str, Field(strict=True, min_length=1, max_length=100, pattern=r"^[^\n\r\t]*$")]
)


def _case(document: Document, spec: SuiteSpec, folder: Path, place: int) -> Case:
    at: FieldPath = ("cases", place)
    data = dict(spec.cases[place])
    if "name" not in data:
        raise document.error("has no name", at, remedy="add name: ...")
    name = _checked(document, lambda: _NAME.validate_python(data.pop("name")), (*at, "name"))
    if "detectors" in data:
        raise document.error(
            "is no key of a case",
            (*at, "detectors"),
            remedy="leave it out: a baseline is of one detector, which --detector names",
        )
    if "sweep" in data:
        return Case(name, _named_sweep(document, data, folder, at))
    if spec.scene is not None:
        data.setdefault("scene", spec.scene)
    data.setdefault("repeats", spec.repeats)
    return Case(name, _enough(sweep_within(document, data, folder, at), document, at))


def _named_sweep(
    document: Document, data: dict[str, Any], folder: Path, at: FieldPath
) -> SweepFile:
    """Read the sweep file that a case names."""
    file = data.pop("sweep")
    more = next(iter(data), None)
    if more is not None:
        raise document.error("stands beside sweep", (*at, more), remedy="leave one of them out")
    if not isinstance(file, str):
        raise document.error(
            f"has to name a file, not {shown(file)}", (*at, "sweep"), remedy=_REMEDY
        )
    read = read_sweep(folder / file)
    own = SweepFile(
        read.spec.model_copy(update={"detectors": None}), read.scene_file, read.document
    )
    return _enough(own, document, (*at, "sweep"))


def _enough(sweep: SweepFile, document: Document, at: FieldPath) -> SweepFile:
    if sweep.spec.repeats < 2:
        raise document.error(
            "has one repeat, which tells nothing of its scatter", at, remedy="give repeats: 12"
        )
    return sweep


def _checked(document: Document, validate: Callable[[], Any], at: FieldPath = ()) -> Any:
    try:
        return validate()
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = (*at, *(part for part in first["loc"]))
        said = {"extra_forbidden": "is no key of a suite", "missing": "is missing"}
        problem = said.get(first["type"]) or first["msg"].replace("Input should ", "has to ")
        if first["type"] == "extra_forbidden":
            remedy = f"known keys: {', '.join(SuiteSpec.model_fields)}"
        else:
            remedy = _REMEDY
        raise document.error(problem[:1].lower() + problem[1:], place, remedy=remedy) from None


def sweep_of(case: Case, detector: list[Any] | None) -> SweepSpec:
    """Give a case as a sweep of these detectors; None are those of its scene."""
    return case.sweep.spec.model_copy(update={"detectors": detector})
