"""The parts of a table: Parquet files that appear whole.

Of rows with the same key the latest counts.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simtip.errors import InputError
from simtip.sweep.columns import Row, fitting
from simtip.sweep.durable import appearing
from simtip.sweep.head import META, Head

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    from numpy.typing import NDArray
    from pyarrow import parquet

MERGE_ABOVE = 64
"""More parts than this are merged."""

PART_ROWS = 500_000
"""A merged part has about this many rows at most."""

BATCH_ROWS = 20_000
"""So many rows are in memory at once where a table is streamed."""

_PART = re.compile(r"part-(\d{8,12})\.parquet")
_AGAIN = "remove it and run the sweep again: its trials will be computed anew"


def part_name(number: int) -> str:
    """Give the name of a part."""
    return f"part-{number:08d}.parquet"


def number_of(part: Path) -> int:
    """Give a part's number."""
    match = _PART.fullmatch(part.name)
    return int(match[1]) if match else 0


def parts_in(folder: Path) -> list[Path]:
    """List the parts by their numbers; raises FileNotFoundError if there is no such folder."""
    return sorted((p for p in folder.iterdir() if _PART.fullmatch(p.name)), key=number_of)


def as_table(rows: Sequence[Row], head: Head) -> pa.Table:
    """Turn rows into Arrow's columns.

    Raises
    ------
    TypeError
        A value does not fit its column, or there is no such column.
    """
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


def write_part(target: Path, schema: pa.Schema, tables: Iterable[pa.Table]) -> None:
    """Write a part, which appears whole; OSError if the disk is full."""
    from pyarrow import parquet

    with (
        appearing(target) as stream,
        parquet.ParquetWriter(
            stream, schema, compression="zstd", write_page_checksum=True
        ) as writer,
    ):
        for table in tables:
            writer.write_table(table)


def write_rows(folder: Path, head: Head, rows: Iterable[Sequence[Row]]) -> None:
    """Write all rows into a new folder, batch by batch."""
    folder.mkdir()
    tables = _gathered(as_table(batch, head) for batch in rows if batch)
    for number, first in enumerate(tables, start=1):
        write_part(folder / part_name(number), head.schema(), _one_part(first, tables))


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


def merge_small(parts: list[Path], schema: pa.Schema) -> None:
    """Merge small parts into larger ones if there are many; a kill at any moment is harmless."""
    if len(parts) <= MERGE_ABOVE:
        return
    sizes = [_row_count(part, schema) for part in parts]
    if sum(size < PART_ROWS // 2 for size in sizes) <= MERGE_ABOVE:
        return
    for group in _neighbours(parts, sizes):
        merge(group, schema)


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


def merge(group: list[Path], schema: pa.Schema) -> None:
    """Put parts in the last one's place, then remove the others: a kill between leaves doubles."""
    write_part(group[-1], schema, _gathered(latest_rows(group, schema)))
    for part in group[:-1]:
        part.unlink(missing_ok=True)


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


def frame_of(head: Head, parts: list[Path]) -> pd.DataFrame:
    """Read all rows, the latest of each key, in order of ``trial``."""
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


def keys_of(head: Head, parts: list[Path]) -> dict[str, str]:
    """Read the latest status of each key."""
    schema = head.schema()
    found: dict[Any, str] = {}
    for part in parts:
        with _opened(part, schema) as file:
            for batch in file.iter_batches(BATCH_ROWS, columns=["key", "status"]):
                states = [sys.intern(s or "") for s in batch.column("status").to_pylist()]
                found.update(zip(batch.column("key").to_pylist(), states, strict=True))
    return found


def latest_rows(parts: list[Path], schema: pa.Schema) -> Iterator[pa.Table]:
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
