"""The folder of a check: its own, or none yet."""

from __future__ import annotations

from pathlib import Path

from simtip.errors import InputError
from simtip.regress.performed import SWEEPS
from simtip.regress.result import RESULT

OWN = {SWEEPS, RESULT, "report.html"}
"""What may be in it; the last is what `simtip report` makes of it."""


def check_folder(folder: Path) -> None:
    """Refuse a folder that holds something else than a check's results.

    Raises
    ------
    InputError
        It does, or cannot be read.
    """
    if not str(folder).strip(". "):
        raise InputError("is no folder of its own", field="--out", remedy="name a new folder")
    try:
        strangers = sorted(
            one.name for one in folder.iterdir() if one.name[0] != "." and one.name not in OWN
        )
    except FileNotFoundError:
        return
    except OSError as error:
        raise InputError(
            f"cannot be a folder of results ({error.strerror})",
            file=folder,
            remedy="name another folder",
        ) from error
    if strangers:
        raise InputError(
            f"holds something else ({strangers[0]})", file=folder, remedy="name another folder"
        )
