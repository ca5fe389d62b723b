"""``table.json``: a table's columns, where its rows come from, and which folder holds them."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simtip.errors import InputError
from simtip.input_file import read_bytes, require_folder
from simtip.sweep.columns import Column, checked

if TYPE_CHECKING:
    import pyarrow as pa

FORMAT = 1
HEAD = "table.json"
META = b"simtip"
"""Key of the provenance in every part's own metadata."""

ROWS_FOLDER = re.compile(r"rows(?:-(\d{1,9}))?")
MAX_HEAD_BYTES = 1 << 26


@dataclass(frozen=True)
class Head:
    """What ``table.json`` says."""

    columns: tuple[Column, ...]
    provenance: dict[str, Any]
    rows: str = "rows"

    def text(self) -> bytes:
        """Give the file; raises ValueError for a provenance that JSON cannot hold."""
        columns = [asdict(column) for column in self.columns]
        told = {"format": FORMAT, "rows": self.rows, "columns": columns}
        told["provenance"] = self.provenance
        return (json.dumps(told, indent=1, allow_nan=False) + "\n").encode()

    def schema(self) -> pa.Schema:
        """Give the columns as Arrow has them, with the provenance."""
        import pyarrow as pa

        types = {"int": pa.int64(), "float": pa.float64(), "text": pa.string(), "bool": pa.bool_()}
        fields = [
            pa.field(column.name, types[column.kind], nullable=column.name != "key")
            for column in self.columns
        ]
        return pa.schema(fields, metadata={META: json.dumps(self.provenance)})


def read_head(folder: Path) -> Head:
    """Read it.

    Raises
    ------
    InputError
        There is no such folder, no table in it, or the file is damaged or of another format.
    """
    file = folder / HEAD
    require_folder(folder, "name the folder of a sweep")
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


def _parsed_head(found: dict[str, Any], file: Path) -> Head:
    if found["format"] != FORMAT:
        raise InputError(
            f"has format {str(found['format'])[:20]}, not {FORMAT}",
            file=file,
            remedy="read it with the version of simtip that wrote it",
        )
    columns = checked(Column(str(c["name"]), c["kind"]) for c in found["columns"])
    rows, provenance = found["rows"], found["provenance"]
    if not ROWS_FOLDER.fullmatch(rows) or not isinstance(provenance, dict):
        raise ValueError(rows)
    return Head(columns, provenance, rows)


def rows_name_after(name: str) -> str:
    """Give the name of the folder of rows that takes the place of this one."""
    match = ROWS_FOLDER.fullmatch(name)
    return f"rows-{int((match and match[1]) or 0) + 1}"
