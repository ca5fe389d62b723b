"""Rig files that a command may write."""

from __future__ import annotations

from pathlib import Path

from simtip.errors import InputError
from simtip.rig_file import Format, rig_files


def require_new(out: Path, form: Format | None) -> None:
    """Refuse a rig file that exists: it may be somebody's calibration."""
    for file in rig_files(out, form):
        if file.exists():
            raise InputError("exists", file=file, remedy="name another file or remove this one")
        if not file.parent.is_dir() and file.parent != out:
            raise InputError("its folder does not exist", file=file, remedy="make the folder first")
