"""Tables of sweeps that hold what no sweep writes."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow as pa
from pyarrow import parquet


def without_column(folder: Path, name: str) -> None:
    """Leave a column out, of the head and of all parts."""
    head = json.loads((folder / "table.json").read_text())
    head["columns"] = [column for column in head["columns"] if column["name"] != name]
    (folder / "table.json").write_text(json.dumps(head))
    for part in folder.glob("rows/*.parquet"):
        parquet.write_table(parquet.read_table(part).drop_columns([name]), part)


def filled(folder: Path, name: str, value: object) -> None:
    """Give all rows the same value in a column."""
    for part in folder.glob("rows/*.parquet"):
        table = parquet.read_table(part)
        at = table.schema.get_field_index(name)
        field = table.schema.field(at)
        column = pa.array([value] * len(table), field.type)
        parquet.write_table(table.set_column(at, field, column), part)
