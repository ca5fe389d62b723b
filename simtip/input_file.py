"""Files that a user named, read whole and within limits."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from simtip.errors import InputError


def read_bytes(path: str | Path, max_bytes: int) -> bytes:
    """Read a regular file that a user named.

    Parameters
    ----------
    path
        The file.
    max_bytes
        The largest size accepted.

    Raises
    ------
    InputError
        The file is missing, a folder, a device or pipe, unreadable, empty or too large.
    """
    try:
        file = Path(path)
        size = _regular_size(file.stat(), path, max_bytes)
        with file.open("rb") as stream:
            data = stream.read(size)
    except InputError:
        raise
    except (FileNotFoundError, NotADirectoryError):
        raise InputError("no such file", file=path, remedy="check the path") from None
    except PermissionError:
        raise InputError("may not be read", file=path, remedy="check its permissions") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"cannot be read ({reason})", file=path, remedy="check the path"
        ) from error
    if not data:
        raise InputError("is empty", file=path, remedy="was it written to the end?")
    return data


def require_folder(path: Path, remedy: str) -> None:
    """Refuse what is no folder.

    Raises
    ------
    InputError
        It is none, or cannot be looked at: its name is too long, for example.
    """
    try:
        if path.is_dir():
            return
        problem = "is not a folder" if path.exists() else "no such folder"
    except OSError as error:
        problem = f"cannot be read ({error.strerror or error})"
    raise InputError(problem, file=path, remedy=remedy)


def _regular_size(info: os.stat_result, path: str | Path, max_bytes: int) -> int:
    if stat.S_ISDIR(info.st_mode):
        raise InputError("is a folder", file=path, remedy="name a file")
    # A pipe or device may never end.
    if not stat.S_ISREG(info.st_mode):
        raise InputError("is not a regular file", file=path, remedy="save it to disk first")
    if info.st_size > max_bytes:
        raise InputError(
            f"has {info.st_size} bytes, more than the limit of {max_bytes}",
            file=path,
            remedy="is it the right file?",
        )
    return info.st_size
