"""What a user can cause, said in one line."""

from __future__ import annotations

from pathlib import Path


class SimtipError(Exception):
    """Base of every error that simtip raises on purpose."""


class InputError(SimtipError, ValueError):
    """Something that the user gave cannot be used; the command line exits with 2.

    Parameters
    ----------
    problem
        What is wrong, with the value found.
    file
        The file (or folder) it was found in, if any.
    line
        1-based line in that file, if known.
    field
        Dotted path of the field, e.g. ``needle.tip.kind`` or ``lamps[0].power``.
    remedy
        What to do about it.
    """

    def __init__(
        self,
        problem: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        field: str | None = None,
        remedy: str | None = None,
    ) -> None:
        self.problem = problem
        self.file = None if file is None else str(file)
        self.line = line
        self.field = field
        self.remedy = remedy
        super().__init__(str(self))

    def __str__(self) -> str:
        """Give the one line: ``file:line: field: problem; remedy``."""
        place = self.file or ""
        if place and self.line is not None:
            place = f"{place}:{self.line}"
        text = ": ".join(part for part in (place, self.field, self.problem) if part)
        if self.remedy:
            text = f"{text}; {self.remedy}"
        return " ".join(text.split())


class BackendError(SimtipError, RuntimeError):
    """The renderer cannot do this on this machine; `simtip doctor` says what to install."""
