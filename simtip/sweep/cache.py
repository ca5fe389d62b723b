"""Results kept under the digest of all that they depend on, shared by every process of a machine.

What is kept can always be worked out again, so a cache that fails costs time and nothing else: no
call here raises because the disk is full or the folder is gone. An entry is a folder that is whole
or not there at all, whoever is killed when; a log is a file of short records, each whole or
skipped. What was not used for longest goes first when the cache is full.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from platformdirs import user_cache_path

from simtip.errors import InputError
from simtip.sweep.cache_items import (
    Item,
    Kind,
    below,
    by_kind,
    items_in,
    last_use_ns,
    size_of,
)
from simtip.sweep.cache_layout import LOG_ENDING, lock_of, log_of, place_of, root_of
from simtip.sweep.cache_leftovers import remove_leftovers, temporary_in
from simtip.sweep.durable import synchronise
from simtip.sweep.locked_file import let_go, open_locked, unlink_if_unlocked
from simtip.sweep.log_records import added, append, framed, records

FOLDER_VARIABLE = "SIMTIP_CACHE"
DEFAULT_LIMIT_BYTES = 20_000_000_000
SHARE = 20
"""A process looks through the whole cache when it has added 1/20 of the limit; then as much is
left free, or a full cache would have to be looked through at every entry."""


def default_folder() -> Path:
    """Give the folder that ``SIMTIP_CACHE`` names, else this user's usual place for caches."""
    named = os.environ.get(FOLDER_VARIABLE)
    return Path(named) if named else user_cache_path("simtip")


class Cache:
    """Entries and logs in a folder, under a kind and the digest of what they depend on.

    Any number of processes may use one folder at a time. An instance may be handed to others; it
    holds nothing open.

    Parameters
    ----------
    folder
        Where; it is made when something is put there. Only what is laid out as a cache is ever
        removed from it.
    limit_bytes
        What it may fill, None for no limit. Each process that adds at the same time may pass it by
        1/20.

    Notes
    -----
    Every method that takes a kind and a key raises ValueError for a kind that is not ``[a-z]+``
    and for a key that is not 16 to 64 hexadecimal digits in small letters.
    """

    def __init__(self, folder: Path, limit_bytes: int | None = DEFAULT_LIMIT_BYTES) -> None:
        # A process may change its working folder.
        self.folder = Path(os.path.abspath(folder))  # noqa: PTH100 (resolve follows links)
        self.limit_bytes = limit_bytes
        self._root = root_of(self.folder)
        self._total: int | None = None  # bytes, when last looked through
        self._added = 0  # bytes, by this process since

    def check(self) -> None:
        """Make the folder, and refuse one that can be neither written nor read.

        Raises
        ------
        InputError
            It is a file, for example.
        """
        try:
            probe = temporary_in(self._root)
            probe.mkdir()
            probe.rmdir()
        except (OSError, ValueError) as error:
            # What others may write still serves.
            if os.path.isdir(self._root) and os.access(self._root, os.R_OK | os.X_OK):  # noqa: PTH112
                return
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(
                f"cannot be used as a cache ({reason})",
                file=self.folder,
                remedy="name another folder",
            ) from error

    def entry(self, kind: str, key: str) -> Path | None:
        """Give the folder of an entry, and mark it as used now.

        Another process may evict it while it is read: then its files are no longer found, and it
        has to be taken as absent.

        Returns
        -------
        Path or None
            None if it is not there.
        """
        folder = place_of(self._root, kind, key)
        if not os.path.isdir(folder):  # noqa: PTH112 (raises nothing)
            return None
        try:
            os.utime(folder)
        except FileNotFoundError:
            return None
        except OSError:
            pass  # others' cache, or one that can only be read
        return folder

    def put(self, kind: str, key: str, write: Callable[[Path], None]) -> Path | None:
        """Keep what a function writes, whole or not at all.

        Parameters
        ----------
        write
            Is given an empty folder to write files into. An OSError that it raises, or an
            InputError about a file in that folder which could not be written, counts as a failure
            of the cache. Any other exception is raised again, and nothing is kept.

        Returns
        -------
        Path or None
            The entry's folder, which another process may have put there first; None if nothing
            could be kept: the disk is full, or this alone is larger than the limit.
        """
        target = place_of(self._root, kind, key)
        try:
            temporary = temporary_in(self._root)
            temporary.mkdir()
        except OSError:
            return None
        try:
            size = _written(temporary, write)
            if self.limit_bytes is not None and size > self.limit_bytes:
                return None
            _move(temporary, target)
        except OSError:
            return None
        except InputError as error:
            if not _tells_of_failed_write(error, temporary):
                raise
            return None
        finally:
            shutil.rmtree(temporary, ignore_errors=True)  # no longer there when all went well
        self._count(size, target)
        return target

    @contextmanager
    def lock(self, kind: str, key: str) -> Iterator[bool]:
        """Let one process at a time work out an entry; the others wait until it is done.

        The system frees the lock when its holder ends, however it ends. It is not re-entrant, and
        a child that was forked while it was held holds it, too.

        Yields
        ------
        bool
            Whether it is locked; False where that is not possible, such as in a folder that can
            only be read.
        """
        path = lock_of(self._root, kind, key)
        descriptor, locked = None, False
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            descriptor, locked = open_locked(path, os.O_RDWR | os.O_CREAT)
        except OSError:
            pass
        try:
            yield locked
        finally:
            if descriptor is not None:
                let_go(descriptor, path if locked else None)

    def append(self, kind: str, key: str, line: str) -> None:
        """Add a record to a log, whole or, when it cannot be written, not at all.

        Parameters
        ----------
        line
            Any text without line feeds, such as JSON.

        Raises
        ------
        ValueError
            There is a line feed in it.
        """
        record = framed(line.encode("utf-8", "surrogatepass"))
        path = log_of(self._root, kind, key)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            size = append(path, record)
        except OSError:
            return
        self._count(size, path)

    def lines(self, kind: str, key: str) -> list[str]:
        """Give the records of a log as they were added, and mark it as used now.

        Records that a kill or a full disk cut short are left out, and only those.
        """
        return self.added_lines(kind, key, 0)[0]

    def added_lines(self, kind: str, key: str, read_bytes: int) -> tuple[list[str], int]:
        """Give the records of a log beyond those read before, and what has been read now, bytes.

        The last record may come again: it could have been cut short.
        """
        path = log_of(self._root, kind, key)
        data, read_bytes = added(path, read_bytes)
        with suppress(OSError):
            os.utime(path)
        return list(records(data)), read_bytes

    def discard(self, kind: str, key: str) -> None:
        """Remove what is kept under a key, entry and log, because it is damaged."""
        for path in (place_of(self._root, kind, key), log_of(self._root, kind, key)):
            self._remove(path)

    def summary(self) -> dict[str, Kind]:
        """Say what there is, by kind, in the order of the alphabet."""
        return by_kind(self._items())

    def clear(self, kind: str | None = None) -> int:
        """Remove everything, or everything of one kind.

        Returns
        -------
        int
            Bytes freed.
        """
        return sum(item.bytes for item in self._items(kind) if self._remove(item.path))

    def trim(self, limit_bytes: int) -> int:
        """Remove what was not used for longest until the rest fits into a limit.

        Returns
        -------
        int
            Bytes freed.
        """
        items = list(self._items())
        return self._evict(items, sum(item.bytes for item in items) - limit_bytes)

    def sweep_up(self) -> int:
        """Remove what killed processes left: unfinished folders, and files of locks.

        That of processes of other machines and containers is removed when it is a day old.

        Returns
        -------
        int
            Bytes freed.
        """
        return remove_leftovers(self._root)

    def _items(self, kind: str | None = None) -> Iterator[Item]:
        """Look through the cache, at least that of one kind; others may change it meanwhile."""
        return items_in(self._root, kind)

    def _count(self, size: int, just_used: Path) -> None:
        """Take note of added bytes; where they may pass the limit, look and make room."""
        limit = self.limit_bytes
        if limit is None:
            return
        self._added += size
        known = self._total is not None and self._total + self._added <= limit
        if known and self._added <= limit // SHARE:
            return
        items = list(self._items())
        total = sum(item.bytes for item in items)
        if total > limit:
            kept = [i for i in items if i.path != just_used or i.bytes > limit]
            total -= self._evict(kept, total - limit + limit // SHARE)
        self._total, self._added = total, 0

    def _evict(self, items: list[Item], excess: int) -> int:
        """Remove items, those not used for longest first, until so many bytes are freed."""
        freed = 0
        for item in sorted(items, key=lambda item: item.used_ns):
            if freed >= excess:
                break
            if last_use_ns(item.path) == item.used_ns:
                self._remove(item.path)
            # What another process evicts makes room as well; each would go on alone otherwise.
            if not os.path.lexists(item.path):
                freed += item.bytes
        return freed

    def _remove(self, path: Path) -> bool:
        """Remove an entry or a log, and say whether this call did."""
        if path.suffix == LOG_ENDING:
            return unlink_if_unlocked(path)
        try:
            temporary = temporary_in(self._root)
            path.rename(temporary)  # readers find all of it or none
        except OSError:
            return False
        shutil.rmtree(temporary, ignore_errors=True)
        return True


def _written(folder: Path, write: Callable[[Path], None]) -> int:
    """Let the function write, see it safely onto the disk, and give its size in bytes."""
    write(folder)
    if os.name == "posix":
        # A rename may outlive a power cut when what was written does not; and some file systems
        # find only now that the disk is full.
        for found in below(folder):
            if found.is_file(follow_symlinks=False):
                synchronise(found.path)
        with suppress(OSError):
            synchronise(folder)
    os.utime(folder)
    return size_of(folder)


def _move(source: Path, target: Path) -> None:
    """Rename a folder, unless another process was first with what has the same name."""
    target.parent.mkdir(parents=True, exist_ok=True)
    try:
        source.rename(target)
    except OSError:
        if not target.is_dir():
            raise


def _tells_of_failed_write(error: InputError, folder: Path) -> bool:
    """Say whether it is an OSError in this folder, put into words."""
    inside = error.file is not None and Path(error.file).is_relative_to(folder)
    return inside and isinstance(error.__cause__, OSError)
