"""Results on disk are whole or not there at all."""

from __future__ import annotations

import os
import secrets
import shutil
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from simtip.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import TracebackType

UNWRITABLE_REMEDY = "free some space or name another output folder"

PREFIX = ".simtip-"
"""Temporary files and folders begin with this, beside the place they are meant for."""


class OutputFolder:
    """A folder that appears under its name only when everything in it is written.

    ``with OutputFolder(path) as folder:`` gives a temporary folder next to the target. On success
    it is renamed to the target, which may exist if it is empty; on any exception it is removed,
    with the parent folders that were made for it.

    Parameters
    ----------
    path
        The folder to make.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = path
        self._target = Path()
        self._temporary: Path | None = None
        self._made: list[Path] = []

    def check(self) -> None:
        """Refuse early, before long work, and leave nothing behind.

        Raises
        ------
        InputError
            The target is a file, a folder that is not empty, the working folder or a mount point,
            or cannot be made.
        """
        try:
            target = Path(os.path.realpath(self.path))
            self._check_target(target)
            # Trying is the only sure test: permission bits say little about the file system.
            probe = _existing(target.parent) / f"{PREFIX}{secrets.token_hex(8)}"
            probe.mkdir()
            probe.rmdir()
        except InputError:
            raise
        except (OSError, ValueError) as error:
            raise self._unwritable(error) from error

    def _check_target(self, target: Path) -> None:
        if not os.path.lexists(target):
            # Too long a name would only fail at the end.
            _check_name(target)
            return
        if not target.is_dir():
            raise InputError(
                "exists and is not a folder", file=self.path, remedy="name another output folder"
            )
        if any(target.iterdir()):
            raise InputError(
                "exists and is not empty",
                file=self.path,
                remedy="name another output folder or empty this one",
            )
        if os.path.ismount(target) or target == Path(os.path.realpath(".")):
            raise InputError(
                "is the working folder or a mount point, which cannot be replaced",
                file=self.path,
                remedy="name a folder inside it",
            )

    def _unwritable(self, error: Exception) -> InputError:
        reason = getattr(error, "strerror", None) or str(error)
        return InputError(
            f"cannot be written ({reason})", file=self.path, remedy="name another output folder"
        )

    def __enter__(self) -> Path:
        """Check, then make and give the temporary folder."""
        self.check()
        try:
            self._target = Path(os.path.realpath(self.path))
            self._make_parents()
            temporary = self._target.parent / f"{PREFIX}{secrets.token_hex(8)}"
            temporary.mkdir()
        except OSError as error:
            self._remove()
            raise self._unwritable(error) from error
        self._temporary = temporary
        return temporary

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Rename the folder to its target, or remove it after an exception."""
        if kind is not None or self._temporary is None:
            self._remove()
            return
        try:
            _replace_folder(self._temporary, self._target)
        except OSError as problem:
            self._remove()
            raise self._unwritable(problem) from problem
        except BaseException:
            self._remove()
            raise
        self._temporary = None

    def _make_parents(self) -> None:
        missing = []
        folder = self._target.parent
        while not folder.exists():
            missing.append(folder)
            folder = folder.parent
        for folder in reversed(missing):
            folder.mkdir(exist_ok=True)
            self._made.append(folder)

    def _remove(self) -> None:
        if self._temporary is not None:
            shutil.rmtree(self._temporary, ignore_errors=True)
            self._temporary = None
        for folder in reversed(self._made):
            try:
                folder.rmdir()
            except OSError:
                break  # someone else uses it by now
        self._made = []


@contextmanager
def result_folder(path: str | Path) -> Iterator[Path]:
    """Give a folder to write results into, which appears whole or not at all.

    Parameters
    ----------
    path
        See `OutputFolder`.

    Raises
    ------
    InputError
        The folder, or something in it, cannot be written: the disk is full, for example.
    """
    folder = None
    try:
        with OutputFolder(path) as folder:
            yield folder
    except InputError as error:
        # Nobody knows the temporary folder's name.
        if folder is None or error.file is None or not Path(error.file).is_relative_to(folder):
            raise
        inside = Path(path) / Path(error.file).relative_to(folder)
        raise InputError(error.problem, file=inside, remedy=UNWRITABLE_REMEDY) from error
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"cannot be written ({reason})", file=path, remedy=UNWRITABLE_REMEDY
        ) from error


def write_atomically(path: str | Path, data: bytes) -> None:
    """Write a file so that it is either whole or as it was before.

    Parameters
    ----------
    path
        The file; an existing one is replaced. Its folder has to exist.
    data
        What it shall hold.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    target = Path(path)
    temporary = target.parent / f"{PREFIX}{secrets.token_hex(8)}"
    try:
        _check_file(target)
        with temporary.open("xb") as stream:
            stream.write(data)
        temporary.replace(target)
    except InputError:
        raise
    except (OSError, ValueError) as error:
        _discard(temporary)
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"cannot be written ({reason})", file=path, remedy="name another file"
        ) from error
    except BaseException:
        _discard(temporary)
        raise


def check_new_file(path: Path, endings: tuple[str, ...]) -> None:
    """Refuse early a file that exists, has another ending or has no folder.

    Raises
    ------
    InputError
        It does.
    """
    if path.suffix.lower() not in endings:
        known = " or ".join(endings)
        raise InputError(
            f"ends in {path.suffix!r}", file=path, remedy=f"name a file that ends in {known}"
        )
    try:
        there = path.exists()
    except OSError as error:  # too long a name, for example
        reason = error.strerror or str(error)
        raise InputError(
            f"cannot be written ({reason})", file=path, remedy="name another file"
        ) from error
    if there:
        raise InputError("exists", file=path, remedy="name another file or remove this one")
    check_writable(path)


def check_writable(path: Path) -> None:
    """Refuse early, before long work, a file that `write_atomically` could not write.

    Raises
    ------
    InputError
        It is a folder, no regular file, or its folder is not there or cannot be written.
    """
    probe = path.parent / f"{PREFIX}{secrets.token_hex(8)}"
    try:
        _check_place(path)
        # Trying is the only sure test: permission bits say little about the file system.
        probe.open("xb").close()
        probe.unlink()
    except InputError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"cannot be written ({reason})", file=path, remedy="name another file"
        ) from error


def _check_place(target: Path) -> None:
    if target.is_dir():
        raise InputError("is a folder", file=target, remedy="name a file")
    if not target.parent.is_dir():
        raise InputError("its folder does not exist", file=target, remedy="make the folder first")
    _check_file(target)


def _check_file(target: Path) -> None:
    # Renaming would put a file in the place of a device such as /dev/null.
    if target.exists() and not target.is_file():
        raise InputError("is not a regular file", file=target, remedy="name another file")


def _discard(file: Path) -> None:
    try:
        file.unlink(missing_ok=True)
    except (OSError, ValueError):
        return  # it was never made


def _existing(folder: Path) -> Path:
    """Give the nearest folder upwards that exists."""
    while not os.path.lexists(folder):
        folder = folder.parent
    return folder


def _check_name(target: Path) -> None:
    try:
        target.lstat()
    except FileNotFoundError:
        return


def _replace_folder(source: Path, target: Path) -> None:
    if os.name == "nt" and target.is_dir():
        target.rmdir()  # rename replaces an empty folder everywhere else
    source.rename(target)
