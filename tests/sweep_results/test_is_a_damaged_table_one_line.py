"""Is what cannot be read named, with what to do about it, and never half of a table given?"""

from __future__ import annotations

import errno
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from pyarrow import parquet
from sweep_tables import make, parts, row

from simtip.errors import InputError
from simtip.sweep.table import Table

REMEDY = "remove it and run the sweep again: its trials will be computed anew"
READERS = {
    "frame": Table.frame,
    "keys": Table.keys,
    "batches": lambda table: list(table.batches()),
}


@pytest.fixture
def table(tmp_path) -> Table:
    made = make(tmp_path / "out", [row(k, reason="x" * k) for k in range(20)])
    made.append([row(20)])
    return made


def text_file(part: Path) -> None:
    part.write_text("trial,status\n1,ok\n")


def empty_file(part: Path) -> None:
    part.write_bytes(b"")


def cut_short(part: Path) -> None:
    part.write_bytes(part.read_bytes()[:-9])


def flipped_bit(part: Path) -> None:
    """In the keys, which every reader reads."""
    data = bytearray(part.read_bytes())
    keys = parquet.read_metadata(part).row_group(0).column(0)
    data[keys.data_page_offset // 2] ^= 4
    part.write_bytes(data)


def foreign_columns(part: Path) -> None:
    parquet.write_table(pa.table({"key": ["a"], "status": ["ok"]}), part)


def without_provenance(part: Path) -> None:
    parquet.write_table(parquet.read_table(part).replace_schema_metadata(None), part)


def columns_turned(part: Path) -> None:
    found = parquet.read_table(part)
    parquet.write_table(found.select(found.column_names[::-1]), part)


DAMAGE = {
    text_file: "is damaged or no Parquet file",
    empty_file: "is damaged or no Parquet file",
    cut_short: "is damaged or no Parquet file",
    flipped_bit: "is damaged or no Parquet file",
    foreign_columns: "is no part of this table",
    without_provenance: "is no part of this table",
    columns_turned: "is no part of this table",
}


@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
@pytest.mark.parametrize(("damage", "problem"), DAMAGE.items(), ids=[d.__name__ for d in DAMAGE])
def test_a_part_that_is_no_good_is_named(table, read, damage, problem):
    part = parts(table.folder)[0]
    damage(part)
    with pytest.raises(InputError) as caught:
        read(table)
    assert (caught.value.file, caught.value.problem) == (str(part), problem)
    assert caught.value.remedy == REMEDY
    part.unlink()  # as the remedy says
    assert list(table.keys()) == [row(20)["key"]]


@pytest.mark.slow
def test_no_flipped_bit_changes_a_value_unseen(table):
    part = parts(table.folder)[0]
    data, whole = part.read_bytes(), table.frame()
    rng = np.random.default_rng(3)
    seen = 0
    for _ in range(150):
        changed = bytearray(data)
        changed[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
        part.write_bytes(changed)
        try:
            frame = table.frame()
        except InputError:
            seen += 1
        else:
            pd.testing.assert_frame_equal(frame, whole)
    assert seen > 75


def test_a_part_that_may_not_be_read_is_not_called_damaged(table, monkeypatch):
    def refuse(*_):
        raise PermissionError(errno.EACCES, "Failed to open")

    monkeypatch.setattr(pa, "OSFile", refuse)
    with pytest.raises(InputError, match=r"cannot be read \(Permission denied\); check its perm"):
        table.frame()


def test_files_of_other_names_are_no_parts(table):
    rows = table.folder / "rows"
    for name in ("part-00000003 (copy).parquet", "notes.txt", "part-x.parquet", "part-1.parquet"):
        (rows / name).write_text("mine")
    assert len(table.frame()) == len(table.keys()) == 21


def test_missing_rows_are_said_in_a_line_and_computed_anew(table, monkeypatch):
    monkeypatch.setattr("simtip.sweep.table._PAUSE_S", 0)
    for part in parts(table.folder):
        part.unlink()
    (table.folder / "rows").rmdir()
    with pytest.raises(InputError, match=r"out/rows: parts of it are missing.*run the sweep again"):
        table.frame()
    Table.open(table.folder).append([row(0)])
    assert len(table.frame()) == 1


def head(folder: Path, **changed) -> str:
    told = json.loads((folder / "table.json").read_text())
    return json.dumps({**told, **changed})


HEADS = {
    "no JSON": lambda _: "not JSON",
    "cut short": lambda folder: head(folder)[:-10],
    "no object": lambda _: "[1, 2]",
    "deep": lambda _: "[" * 100_000,
    "no UTF-8": lambda _: b"\xff\xfe\x00",
    "nothing": lambda _: "{}",
    "columns": lambda folder: head(folder, columns=[{"name": "key"}]),
    "a kind": lambda folder: head(folder, columns=[{"name": "key", "kind": ["text"]}]),
    "no key": lambda folder: head(folder, columns=[]),
    "another folder": lambda folder: head(folder, rows="../elsewhere"),
    "provenance": lambda folder: head(folder, provenance=3),
    "empty": lambda _: "",
}


@pytest.mark.parametrize("content", HEADS.values(), ids=HEADS)
def test_a_damaged_head_is_one_line(table, content):
    new = content(table.folder)
    (table.folder / "table.json").write_bytes(new if isinstance(new, bytes) else new.encode())
    for call in (Table.open, lambda _: table.frame(), lambda _: table.append([row(3)])):
        with pytest.raises(InputError, match=r"out/table.json: is (damaged|empty)"):
            call(table.folder)


def test_another_format_is_said(table):
    (table.folder / "table.json").write_text(head(table.folder, format=2))
    with pytest.raises(InputError, match=r"table.json: has format 2, not 1; read it with the ver"):
        Table.open(table.folder)


@pytest.mark.parametrize(
    ("name", "problem"),
    [("none", "no such folder"), ("file", "is not a folder"), ("empty", "holds no table")],
)
def test_a_folder_without_a_table_is_said(tmp_path, name, problem):
    (tmp_path / "file").write_text("x")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=f"{name}: {problem}.*; name the folder of a sweep"):
        Table.open(tmp_path / name)
