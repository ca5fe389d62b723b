"""The table of a sweep's results on disk: one row a trial, in Parquet parts that appear whole.

``table.json`` says which columns there are, where the rows come from, and which folder holds them
as ``part-<number>.parquet``. Of rows with the same key the latest counts: the last one of the part
with the highest number. So merging parts, or a kill at any moment, loses no row and doubles none.

One process writes at a time; any number of others may read meanwhile.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import shutil
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar

import numpy as np

from simtip.errors import InputError
from simtip.input_file import read_bytes
from simtip.output_folder import PREFIX
from simtip.sweep.columns import Column, Row, checked, fitting

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    from numpy.typing import NDArray
    from pyarrow import parquet


T = TypeVar("T")

FORMAT = 1
HEAD = "table.json"
META = b"simtip"
"""Key of the provenance in every part's own metadata."""

OK = "ok"
"""Status of a trial that was measured."""

MERGE_ABOVE = 64
"""More parts than this are merged."""

PART_ROWS = 500_000
"""A merged part has about this many rows at most."""

BATCH_ROWS = 20_000
"""So many rows are in memory at once where a table is streamed."""

MAX_HEAD_BYTES = 1 << 26
ATTEMPTS = 100
"""A reader lists the parts anew so often, at most, when one vanishes: they were merged."""

_PAUSE_S = 0.02
_TEMPORARY = f"{PREFIX}table-"
_ROWS_FOLDER = re.compile(r"rows(?:-(\d{1,9}))?")
_PART = re.compile(r"part-(\d{8,12})\.parquet")
_AGAIN = "remove it and run the sweep again: its trials will be computed anew"


class Table:
    """A table of results on disk.

    Parameters
    ----------
    folder
        Where it is.

    Raises
    ------
    InputError
        There is no such folder, no table in it, or ``table.json`` is damaged or of another format.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._head = _read_head(folder)
        self._tidied = False

    @classmethod
    def create(cls, folder: Path, columns: Sequence[Column], provenance: dict[str, Any]) -> Table:
        """Make an empty table.

        Parameters
        ----------
        folder
            Made if it is missing; what else is in it stays.
        columns
            In order; ``key``, ``trial`` and ``status`` have to be among them.
        provenance
            What JSON can hold about where the rows come from. ``trials``, if there is such a
            number, is told as the number of trials planned.

        Raises
        ------
        InputError
            The folder holds a table or rows already, or cannot be written.
        ValueError
            Columns are missing or have the same name, or the provenance is nothing for JSON.
        """
        head = _Head(checked(columns), provenance)
        text = head.text()
        try:
            rows = folder / head.rows
            rows.mkdir(parents=True, exist_ok=True)
            if (folder / HEAD).exists() or any(rows.iterdir()):
                raise InputError(
                    "holds a table of results already", file=folder, remedy="name another folder"
                )
            _write_file(folder / HEAD, text)
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputError(
                f"cannot be written ({reason})", file=folder, remedy="name another folder"
            ) from error
        return cls(folder)

    @classmethod
    def open(cls, folder: Path) -> Table:
        """Open a table that is there; raises what the class itself does."""
        return cls(folder)

    @property
    def columns(self) -> tuple[Column, ...]:
        """The columns, in order, as they were when the table was last read or written."""
        return self._head.columns

    @property
    def provenance(self) -> dict[str, Any]:
        """Where the rows come from, likewise."""
        return self._head.provenance

    def append(self, rows: Sequence[Row]) -> None:
        """Add rows, as one part that appears whole.

        Parameters
        ----------
        rows
            By the columns' names; what a row lacks is missing. The key may not be missing.

        Raises
        ------
        TypeError
            A value does not fit its column, or there is no such column; nothing is written.
        OSError
            The disk is full, for example; nothing is left behind.
        """
        head = self._begin()
        if not rows:
            return
        table = _as_table(rows, head)
        folder = self.folder / head.rows
        folder.mkdir(exist_ok=True)  # somebody may have removed all rows, to compute them anew
        parts = _parts(folder)
        last = _number(parts[-1]) if parts else 0
        _write_part(folder / _part_name(last + 1), head.schema(), [table])

    def compact(self) -> None:
        """Merge small parts into larger ones if there are many; a kill at any moment is harmless.

        Raises
        ------
        OSError
            The disk is full, for example; the parts are as they were.
        InputError
            A part is damaged.
        """
        head = self._begin()
        parts = _parts(self.folder / head.rows)
        if len(parts) <= MERGE_ABOVE:
            return
        schema = head.schema()
        sizes = [_row_count(part, schema) for part in parts]
        if sum(size < PART_ROWS // 2 for size in sizes) <= MERGE_ABOVE:
            return
        for group in _neighbours(parts, sizes):
            _merge(group, schema)

    def rewrite(
        self,
        columns: Sequence[Column],
        rows: Iterable[Sequence[Row]],
        provenance: dict[str, Any],
    ) -> None:
        """Replace the whole table; a kill at any moment leaves the old one or the new one.

        Parameters
        ----------
        columns, provenance
            As for `create`.
        rows
            In batches, which are written as they come; may be made from this table's `batches`.

        Raises
        ------
        TypeError, OSError
            As for `append`; the old table stays.
        ValueError
            As for `create`; the old table stays.
        """
        old = self._begin()
        head = _Head(checked(columns), provenance, _rows_name_after(old.rows))
        text = head.text()
        try:
            _write_rows(self.folder / head.rows, head, rows)
            _write_file(self.folder / HEAD, text)
        finally:
            self._head = self._tidy()  # table.json says which of the two is left over

    def frame(self) -> pd.DataFrame:
        """Read all rows, in order of ``trial``; the sweep may go on meanwhile.

        Returns
        -------
        frame
            Columns of int are ``Int64``, of float ``float64`` with NaN, of text ``string`` and of
            bool ``boolean``.

        Raises
        ------
        InputError
            A part is damaged or not of this table.
        """
        return self._steady(_frame)

    def keys(self) -> dict[str, str]:
        """Read the status of every row, by its key; the sweep may go on meanwhile.

        Raises
        ------
        InputError
            A part is damaged or not of this table.
        """
        return self._steady(_keys)

    def batches(self) -> Iterator[list[Row]]:
        """Give all rows, some thousand at a time, in the order they were written, for `rewrite`.

        Only for the process that writes: no other one may merge parts meanwhile.

        Raises
        ------
        InputError
            A part is damaged or not of this table.
        """
        schema = self._head.schema()
        parts = _parts(self.folder / self._head.rows)
        for table in _latest_rows(parts, schema):
            yield table.to_pylist()

    def _begin(self) -> _Head:
        """Read what the table is, before writing; the first time, remove what a kill left."""
        self._head = _read_head(self.folder) if self._tidied else self._tidy()
        self._tidied = True
        return self._head

    def _tidy(self) -> _Head:
        head = _read_head(self.folder)
        for entry in self.folder.iterdir():
            if _ROWS_FOLDER.fullmatch(entry.name) and entry.name != head.rows:
                shutil.rmtree(entry, ignore_errors=True)
        for folder in (self.folder, self.folder / head.rows):
            for entry in folder.glob(f"{_TEMPORARY}*"):
                entry.unlink(missing_ok=True)
        return head

    def _steady(self, read: Callable[[_Head, list[Path]], T]) -> T:
        """Read parts that another process may be merging or replacing."""
        for _ in range(ATTEMPTS):
            self._head = head = _read_head(self.folder)
            try:
                result = read(head, _parts(self.folder / head.rows))
            except FileNotFoundError:
                time.sleep(_PAUSE_S)
                continue
            # A replaced table's parts vanish one by one: what was read may be some of them.
            if _read_head(self.folder).rows == head.rows:
                return result
        raise InputError(
            "parts of it are missing or vanish again and again",
            file=self.folder / self._head.rows,
            remedy="run the sweep again: what is missing will be computed anew",
        )


@dataclass(frozen=True)
class _Head:
    """What ``table.json`` says."""

    columns: tuple[Column, ...]
    provenance: dict[str, Any]
    rows: str = "rows"

    def text(self) -> bytes:
        columns = [asdict(column) for column in self.columns]
        told = {"format": FORMAT, "rows": self.rows, "columns": columns}
        told["provenance"] = self.provenance
        return (json.dumps(told, indent=1, allow_nan=False) + "\n").encode()

    def schema(self) -> pa.Schema:
        import pyarrow as pa

        types = {"int": pa.int64(), "float": pa.float64(), "text": pa.string(), "bool": pa.bool_()}
        fields = [
            pa.field(column.name, types[column.kind], nullable=column.name != "key")
            for column in self.columns
        ]
        return pa.schema(fields, metadata={META: json.dumps(self.provenance)})


def _read_head(folder: Path) -> _Head:
    file = folder / HEAD
    if not folder.is_dir():
        problem = "is not a folder" if folder.exists() else "no such folder"
        raise InputError(problem, file=folder, remedy="name the folder of a sweep")
    if not file.exists():
        raise InputError(
            f"holds no table of results ({HEAD})", file=folder, remedy="name the folder of a sweep"
        )
    data = read_bytes(file, MAX_HEAD_BYTES)
    try:
        return _parsed_head(json.loads(data), file)
    except InputError:
        raise
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise InputError(
            "is damaged or no table of a sweep",
            file=file,
            remedy="restore it, or run the sweep into a new folder",
        ) from error


def _parsed_head(found: dict[str, Any], file: Path) -> _Head:
    if found["format"] != FORMAT:
        raise InputError(
            f"has format {str(found['format'])[:20]}, not {FORMAT}",
            file=file,
            remedy="read it with the version of simtip that wrote it",
        )
    columns = checked(Column(str(c["name"]), c["kind"]) for c in found["columns"])
    rows, provenance = found["rows"], found["provenance"]
    if not _ROWS_FOLDER.fullmatch(rows) or not isinstance(provenance, dict):
        raise ValueError(rows)
    return _Head(columns, provenance, rows)


def _rows_name_after(name: str) -> str:
    match = _ROWS_FOLDER.fullmatch(name)
    return f"rows-{int((match and match[1]) or 0) + 1}"


def _part_name(number: int) -> str:
    return f"part-{number:08d}.parquet"


def _number(part: Path) -> int:
    match = _PART.fullmatch(part.name)
    return int(match[1]) if match else 0


def _parts(folder: Path) -> list[Path]:
    """List the parts by their numbers; raises FileNotFoundError if there is no such folder."""
    return sorted((p for p in folder.iterdir() if _PART.fullmatch(p.name)), key=_number)


# Values


def _as_table(rows: Sequence[Row], head: _Head) -> pa.Table:
    import pyarrow as pa

    schema = head.schema()
    unknown = set().union(*rows) - set(schema.names)
    if unknown:
        raise TypeError(f"there is no column {min(map(repr, unknown))}")
    arrays = [
        pa.array(fitting(column, [row.get(column.name) for row in rows]), field.type)
        for column, field in zip(head.columns, schema, strict=True)
    ]
    return pa.Table.from_arrays(arrays, schema=schema)


# Writing


@contextmanager
def _appearing(target: Path) -> Iterator[BinaryIO]:
    """Give a stream to a file that gets its name when all of it is on the disk."""
    temporary = target.parent / f"{_TEMPORARY}{secrets.token_hex(8)}"
    try:
        with temporary.open("xb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(target)
    except BaseException:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise
    _sync(target.parent)


def _sync(folder: Path) -> None:
    """Have the new name on the disk before old parts go: the power may fail."""
    if os.name != "posix":
        return
    with suppress(OSError):  # not every file system can
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _write_file(target: Path, data: bytes) -> None:
    with _appearing(target) as stream:
        stream.write(data)


def _write_part(target: Path, schema: pa.Schema, tables: Iterable[pa.Table]) -> None:
    from pyarrow import parquet

    with (
        _appearing(target) as stream,
        parquet.ParquetWriter(
            stream, schema, compression="zstd", write_page_checksum=True
        ) as writer,
    ):
        for table in tables:
            writer.write_table(table)


def _write_rows(folder: Path, head: _Head, rows: Iterable[Sequence[Row]]) -> None:
    folder.mkdir()
    tables = _gathered(_as_table(batch, head) for batch in rows if batch)
    for number, first in enumerate(tables, start=1):
        _write_part(folder / _part_name(number), head.schema(), _one_part(first, tables))


def _one_part(first: pa.Table, more: Iterator[pa.Table]) -> Iterator[pa.Table]:
    """Give as many tables as one part shall hold."""
    count = first.num_rows
    yield first
    while count < PART_ROWS:
        table = next(more, None)
        if table is None:
            return
        count += table.num_rows
        yield table


def _gathered(tables: Iterable[pa.Table]) -> Iterator[pa.Table]:
    """Put small tables together: Parquet stores and reads many small groups of rows badly."""
    import pyarrow as pa

    pending: list[pa.Table] = []
    count = 0
    for table in tables:
        pending.append(table)
        count += table.num_rows
        if count >= BATCH_ROWS:
            yield pa.concat_tables(pending)
            pending, count = [], 0
    if pending:
        yield pa.concat_tables(pending)


def _neighbours(parts: list[Path], sizes: list[int]) -> list[list[Path]]:
    """Give runs of parts that are to become one; only neighbours, as the latest row counts."""
    groups: list[list[Path]] = []
    room = 0
    for part, size in zip(parts, sizes, strict=True):
        if not groups or size > room:
            groups.append([])
            room = PART_ROWS
        groups[-1].append(part)
        room -= size
    return [group for group in groups if len(group) > 1]


def _merge(group: list[Path], schema: pa.Schema) -> None:
    """Put parts in the last one's place, then remove the others: a kill between leaves doubles."""
    _write_part(group[-1], schema, _gathered(_latest_rows(group, schema)))
    for part in group[:-1]:
        part.unlink(missing_ok=True)


# Reading


@contextmanager
def _opened(part: Path, schema: pa.Schema) -> Iterator[parquet.ParquetFile]:
    """Open a part for reading; all that goes wrong inside is the part's fault.

    Raises
    ------
    FileNotFoundError
        It is gone.
    InputError
        It cannot be read, is damaged, or is not of this table.
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        with pa.OSFile(str(part), "r") as stream:
            file = parquet.ParquetFile(stream, page_checksum_verification=True)
            _check_schema(file.schema_arrow, schema, part)
            yield file
    except (FileNotFoundError, InputError):
        raise
    except (pa.ArrowException, OSError, ValueError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise InputError(
                f"cannot be read ({os.strerror(error.errno)})",
                file=part,
                remedy="check its permissions and the disk",
            ) from error
        raise InputError("is damaged or no Parquet file", file=part, remedy=_AGAIN) from error


def _check_schema(found: pa.Schema, schema: pa.Schema, part: Path) -> None:
    if META not in (found.metadata or {}) or not found.equals(schema):
        raise InputError("is no part of this table", file=part, remedy=_AGAIN)


def _row_count(part: Path, schema: pa.Schema) -> int:
    with _opened(part, schema) as file:
        return int(file.metadata.num_rows)


def _frame(head: _Head, parts: list[Path]) -> pd.DataFrame:
    import pandas as pd
    import pyarrow as pa

    schema = head.schema()
    tables = [schema.empty_table()]
    for part in parts:
        with _opened(part, schema) as file:
            tables.append(file.read())
    types: dict[Any, Any] = {
        pa.int64(): pd.Int64Dtype(),
        pa.string(): pd.StringDtype(),
        pa.bool_(): pd.BooleanDtype(),
    }
    frame = pa.concat_tables(tables).to_pandas(types_mapper=types.get, ignore_metadata=True)
    frame = frame.drop_duplicates("key", keep="last")
    return frame.sort_values("trial", kind="stable", ignore_index=True)


def _keys(head: _Head, parts: list[Path]) -> dict[str, str]:
    schema = head.schema()
    found: dict[Any, str] = {}
    for part in parts:
        with _opened(part, schema) as file:
            for batch in file.iter_batches(BATCH_ROWS, columns=["key", "status"]):
                states = [sys.intern(s or "") for s in batch.column("status").to_pylist()]
                found.update(zip(batch.column("key").to_pylist(), states, strict=True))
    return found


def _latest_rows(parts: list[Path], schema: pa.Schema) -> Iterator[pa.Table]:
    """Give the rows of some parts, batch by batch, without those that a later one replaces."""
    import pyarrow as pa

    for part, latest in zip(parts, _latest(parts, schema), strict=True):
        start = 0
        with _opened(part, schema) as file:
            for batch in file.iter_batches(BATCH_ROWS):
                chosen = pa.array(latest[start : start + batch.num_rows])
                start += batch.num_rows
                yield pa.Table.from_batches([batch.filter(chosen)], schema)


def _latest(parts: list[Path], schema: pa.Schema) -> list[NDArray[np.bool_]]:
    """Say of each row of each part whether it is the latest of its key."""
    seen: set[Any] = set()
    all_latest = []
    for part in reversed(parts):
        with _opened(part, schema) as file:
            keys = file.read(columns=["key"]).column("key").to_pylist()
        latest = np.zeros(len(keys), dtype=np.bool_)
        for k in range(len(keys) - 1, -1, -1):
            if keys[k] not in seen:
                seen.add(keys[k])
                latest[k] = True
        all_latest.append(latest)
    return all_latest[::-1]
