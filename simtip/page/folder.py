"""Which kind of results a folder holds, and its files read and checked."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

from simtip.errors import InputError
from simtip.input_file import read_bytes, require_folder

Kind = Literal["run", "render", "boards", "calibrate", "sweep", "mca", "budget", "regress"]

MAX_BYTES = 1 << 28
LONGEST_NAME = 255
"""Bytes: no file system has longer ones."""

FILES: tuple[tuple[str, Kind], ...] = (
    ("regress.json", "regress"),
    ("table.json", "sweep"),
    ("calibration.json", "calibrate"),
    ("manifest.json", "render"),
)
"""What only one kind of folder has."""

REMEDY = (
    "name the folder of a run, render, remix, boards, sweep, mca, budget or regress (its -o), or "
    "of calibrate (its --plots)"
)

UNLIKE = (LookupError, TypeError, AttributeError, ValueError, ArithmeticError, RecursionError)
"""What comes of JSON that is not as simtip writes it: fields missing, texts for numbers."""


@dataclass(frozen=True)
class Results:
    """A folder of results.

    Attributes
    ----------
    folder
        Where.
    kind
        Of what.
    """

    folder: Path
    kind: Kind

    def json(self, name: str) -> dict[str, Any]:
        """Read one of its JSON files.

        Raises
        ------
        InputError
            It is missing, damaged or cut short.
        """
        return read_json(self.folder / name)

    def text(self, name: str) -> str:
        """Read one of its text files.

        Raises
        ------
        InputError
            It is missing or damaged.
        """
        try:
            return read_bytes(self.folder / name, MAX_BYTES).decode()
        except UnicodeDecodeError as error:
            raise damaged(self.folder / name) from error


def results_in(folder: Path) -> Results:
    """Recognise a folder of results.

    Raises
    ------
    InputError
        It is none, or not to its end.
    """
    require_folder(folder, REMEDY)
    for name, kind in FILES:
        if (folder / name).is_file():
            measured = kind == "render" and (folder / "result.json").is_file()
            return Results(folder, "run" if measured else kind)
    if (folder / "experiment.json").is_file():
        return _analysis(folder)
    if (folder / "truth.json").is_file():
        return _with_truth(folder)
    raise InputError("holds no results of simtip", file=folder, remedy=REMEDY)


def _analysis(folder: Path) -> Results:
    made_by = read_json(folder / "experiment.json").get("made_by")
    kinds: dict[object, Kind] = {"simtip mca": "mca", "simtip budget": "budget"}
    kind = kinds.get(made_by)
    if kind is None:
        raise damaged(folder / "experiment.json")
    if not (folder / f"{kind}.json").is_file():
        raise InputError(
            f"has not come to its end: there is no {kind}.json",
            file=folder,
            remedy=f"give the same `simtip {kind}` command again: it goes on",
        )
    return Results(folder, kind)


def _with_truth(folder: Path) -> Results:
    truth = read_json(folder / "truth.json")
    if "views" in truth or "poses" in truth or "target" in truth:
        return Results(folder, "boards")
    raise InputError(
        "is cut short: there is no manifest.json",
        file=folder,
        remedy="run it again into a new folder",
    )


def read_json(file: Path) -> dict[str, Any]:
    """Read a JSON file that holds a mapping.

    Raises
    ------
    InputError
        It is missing, damaged or cut short.
    """
    try:
        data = json.loads(read_bytes(file, MAX_BYTES), parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise damaged(file) from error
    if not isinstance(data, dict):
        raise damaged(file)
    return data


def _refuse(constant: str) -> None:
    """Refuse what JSON does not have, and simtip does not write: NaN, Infinity."""
    raise ValueError(constant)


class TakenFrom:
    """Says that a file is damaged where what was read from it is not what simtip writes.

    Parameters
    ----------
    file
        The file.

    Raises
    ------
    InputError
        It is not.
    """

    def __init__(self, file: Path) -> None:
        self._file = file

    def __enter__(self) -> None:
        """Begin to use what was read."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Say it, unless more is known."""
        if isinstance(error, UNLIKE) and not isinstance(error, InputError):
            raise damaged(self._file) from error


def own_file(folder: Path, name: object, listed_in: Path) -> Path:
    """Give a file of a folder by the name that another of its files lists.

    Raises
    ------
    InputError
        The name leads elsewhere.
    """
    plain = isinstance(name, str) and 0 < len(name.encode(errors="replace")) <= LONGEST_NAME
    if not plain or Path(str(name)).name != name or "\\" in str(name):
        raise InputError(
            f"names {str(name)[:80]!r}, which is no file of its folder",
            file=listed_in,
            remedy="restore it, or make the results again",
        )
    return folder / name


def damaged(file: Path) -> InputError:
    """Give the error of a file that does not hold what simtip wrote."""
    return InputError(
        "is damaged or cut short", file=file, remedy="restore it, or make the results again"
    )
