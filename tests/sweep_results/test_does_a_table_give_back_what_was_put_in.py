"""Are the rows of a table those that were appended, in whatever parts they lie?"""

from __future__ import annotations

import json
import math

import numpy as np
import pandas as pd
import pytest
from pyarrow import parquet
from sweep_tables import COLUMNS, FACTORS, PROVENANCE, left_over, make, parts, row

from simtip.errors import InputError
from simtip.sweep import parts as parts_module
from simtip.sweep.columns import FIXED, Column, columns_for
from simtip.sweep.table import Table

TEXTS = ["", " ", "ä\n\t\x00€", "🪡" * 50, "a,b\"c'", "-1", "nan", "[red]x[/red]"]
INTS = [0, -1, 2**53 + 1, 2**63 - 1, -(2**63)]
FLOATS = [0.1, -0.0, 5e-324, 1.7976931348623157e308, math.inf, -math.inf, 1 / 3]


def cells(frame: pd.DataFrame, name: str) -> list[object]:
    found = [None if pd.isna(value) else value for value in frame[name]]
    return [value.item() if isinstance(value, np.generic) else value for value in found]


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("needle.tip.kind", [*TEXTS, None]),
        ("detect.threshold", [*INTS, None]),
        ("lamps[0].power", [*FLOATS, None]),
        ("match.strict", [True, False, None]),
    ],
)
def test_every_value_comes_back_as_it_was(tmp_path, name, values):
    table = make(tmp_path, [{**row(k), name: value} for k, value in enumerate(values)])
    found = cells(Table.open(tmp_path).frame(), name)
    assert list(map(repr, found)) == list(map(repr, values))
    again = [r[name] for batch in table.batches() for r in batch]
    assert list(map(repr, again)) == list(map(repr, values))


def test_a_column_has_the_dtype_of_its_kind_even_if_it_is_empty(tmp_path):
    dtypes = {"int": "Int64", "float": "float64", "text": "string", "bool": "boolean"}
    for rows in ([], [row(0)], [row(1, detect__threshold=3)]):
        folder = tmp_path / str(len(str(rows)))
        frame = make(folder, rows).frame()
        assert len(frame) == len(rows)
        assert {c.name: dtypes[c.kind] for c in COLUMNS} == {
            name: str(kind) for name, kind in frame.dtypes.items()
        }
        assert list(frame.columns) == [column.name for column in COLUMNS]


def test_numbers_of_numpy_are_numbers(tmp_path):
    more = {
        "lamps[0].power": np.float32(0.5),
        "detect.threshold": np.int16(7),
        "match.strict": np.bool_(True),
        "error_norm_mm": 3,
        "error_x_mm": np.float64("nan"),
    }
    table = make(tmp_path, [{**row(0), **more}])
    found = table.frame().iloc[0]
    assert [found[name] for name in list(more)[:4]] == [0.5, 7, True, 3.0]
    assert math.isnan(found["error_x_mm"])
    assert next(table.batches())[0]["error_x_mm"] is None, "NaN is a missing value like any other"


def test_a_name_that_is_no_unicode_is_kept_readable(tmp_path):
    assert make(tmp_path, [row(0, reason="b\udcff.png")]).frame()["reason"][0] == "b\\udcff.png"


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("detect.threshold", 1.0),
        ("detect.threshold", True),
        ("detect.threshold", 2**63),
        ("detect.threshold", math.nan),
        ("lamps[0].power", "1"),
        ("lamps[0].power", False),
        ("lamps[0].power", 10**400),
        ("needle.tip.kind", 1),
        ("needle.tip.kind", b"cone"),
        ("match.strict", 1),
        ("match.strict", "true"),
        ("key", None),
        ("no.such", 1),
    ],
)
def test_a_value_that_does_not_fit_is_refused_and_nothing_written(tmp_path, name, value):
    table = make(tmp_path, [row(0)])
    with pytest.raises(TypeError, match=name.replace("[", r"\[")):
        table.append([row(1), {**row(2), name: value}])
    assert len(parts(tmp_path)) == 1
    assert not left_over(tmp_path)
    assert list(table.keys()) == [row(0)["key"]]


def test_rows_come_in_order_of_trial_and_the_latest_of_a_key_counts(tmp_path):
    table = make(tmp_path, [row(3, status="failed"), row(1), row(2, status="first")])
    table.append([row(0), row(3, status="ok", reason="again")])
    table.append([row(2, status="second"), row(2, status="third"), row(4, trial=None)])
    frame = table.frame()
    assert cells(frame, "trial") == [0, 1, 2, 3, None]
    assert list(frame["status"]) == ["ok", "ok", "third", "ok", "ok"]
    expected = dict(zip(frame["key"], frame["status"], strict=True))
    assert table.keys() == expected
    batches = [r for batch in table.batches() for r in batch]
    assert {r["key"]: r["status"] for r in batches} == expected
    assert len(batches) == 5


@pytest.mark.slow
def test_merging_changes_no_row(tmp_path, monkeypatch):
    monkeypatch.setattr(parts_module, "MERGE_ABOVE", 3)
    monkeypatch.setattr(parts_module, "PART_ROWS", 50)
    monkeypatch.setattr(parts_module, "BATCH_ROWS", 4)
    table = make(tmp_path)
    rng = np.random.default_rng(5)
    expected: dict[str, str] = {}
    for number in range(20):
        # Some keys come again, within a part and in a later one.
        rows = [row(int(k), status=f"{number}.{j}") for j, k in enumerate(rng.integers(0, 150, 9))]
        table.append(rows)
        expected.update({r["key"]: r["status"] for r in rows})
        table.compact()
        assert table.keys() == expected
        frame = table.frame()
        assert dict(zip(frame["key"], frame["status"], strict=True)) == expected
        assert frame["trial"].is_monotonic_increasing
    sizes = [parquet.ParquetFile(part).metadata.num_rows for part in parts(tmp_path)]
    assert len(sizes) < 9
    assert 25 < max(sizes) <= 50


@pytest.mark.slow
def test_few_parts_are_left_alone(tmp_path):
    table = make(tmp_path)
    for k in range(64):
        table.append([row(k)])
    before = {part: part.stat().st_ino for part in parts(tmp_path)}
    table.compact()
    assert {part: part.stat().st_ino for part in parts(tmp_path)} == before
    table.append([row(64)])
    table.compact()
    assert len(parts(tmp_path)) == 1
    # Small groups of rows would be stored and read badly.
    assert parquet.ParquetFile(parts(tmp_path)[0]).metadata.num_row_groups == 1
    assert cells(table.frame(), "trial") == list(range(65))


def test_full_parts_are_not_written_again_and_again(tmp_path, monkeypatch):
    monkeypatch.setattr(parts_module, "MERGE_ABOVE", 2)
    monkeypatch.setattr(parts_module, "PART_ROWS", 4)
    table = make(tmp_path)
    for k in (0, 4, 8):
        table.append([row(k + j) for j in range(4)])
    table.append([row(12)])
    table.append([row(13)])
    before = [(part, part.stat().st_ino) for part in parts(tmp_path)]
    table.compact()
    assert [(part, part.stat().st_ino) for part in parts(tmp_path)] == before
    table.append([row(14)])
    table.compact()
    assert [(part, part.stat().st_ino) for part in parts(tmp_path)][:3] == before[:3]
    assert len(parts(tmp_path)) == 4


def test_no_rows_are_no_part(tmp_path):
    make(tmp_path, []).append([])
    assert parts(tmp_path) == []


def test_rewriting_replaces_all_rows_and_columns(tmp_path, monkeypatch):
    monkeypatch.setattr(parts_module, "PART_ROWS", 10)
    monkeypatch.setattr(parts_module, "BATCH_ROWS", 4)
    table = make(tmp_path, [row(k) for k in range(35)])
    columns = (*columns_for(FACTORS[:1]), Column("sensor.gain", "float"))
    new = (
        [{**{c.name: r.get(c.name) for c in columns}, "sensor.gain": 2.5} for r in batch]
        for batch in table.batches()
    )
    table.rewrite(columns, new, {"trials": 7})
    for reader in (table, Table.open(tmp_path)):
        assert (reader.columns, reader.provenance) == (columns, {"trials": 7})
        frame = reader.frame()
        assert list(frame.columns) == [column.name for column in columns]
        assert cells(frame, "trial") == list(range(35))
        assert set(frame["sensor.gain"]) == {2.5}
    assert len(parts(tmp_path)) == 3
    table.append([row(35)])
    assert len(table.keys()) == 36
    table.rewrite(columns, [], {})
    assert table.keys() == {}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rows-2", "table.json"]


def test_a_rewriting_that_fails_leaves_the_old_table(tmp_path):
    table = make(tmp_path, [row(0)])
    with pytest.raises(TypeError, match="trial"):
        table.rewrite(COLUMNS, [[row(1)], [row(2, trial="2")]], {})
    assert (table.provenance, list(table.keys())) == (PROVENANCE, [row(0)["key"]])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rows", "table.json"]


def test_the_provenance_is_in_the_head_and_in_every_part(tmp_path):
    table = make(tmp_path, [row(0)])
    assert Table.open(tmp_path).provenance == PROVENANCE
    told = parquet.read_schema(parts(tmp_path)[0]).metadata[b"simtip"]
    assert json.loads(told) == PROVENANCE
    table.rewrite(COLUMNS, [[row(0)]], {"new": 1})
    assert json.loads(parquet.read_schema(parts(tmp_path)[0]).metadata[b"simtip"]) == {"new": 1}


def test_what_a_kill_left_is_removed_by_the_next_writer_and_nothing_else(tmp_path):
    make(tmp_path, [row(0)])
    (tmp_path / ".simtip-table-01").write_bytes(b"half")
    (tmp_path / "rows" / ".simtip-table-02").write_bytes(b"half")
    (tmp_path / "rows-1").mkdir()
    (tmp_path / "rows-1" / "part-00000001.parquet").write_bytes(b"half")
    others = [".simtip-0123", "rows.txt", "sweep.yaml"]
    for name in others:
        (tmp_path / name).write_text("of somebody else")
    table = Table.open(tmp_path)
    assert len(table.frame()) == len(table.keys()) == 1
    assert (tmp_path / "rows-1").exists(), "a reader removes nothing"
    table.append([row(1)])
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        [*others, "rows", "table.json"]
    )
    assert [path.name for path in (tmp_path / "rows").iterdir() if path.suffix != ".parquet"] == []


def test_a_folder_with_a_table_is_not_begun_again(tmp_path):
    make(tmp_path, [row(0)])
    with pytest.raises(InputError, match="holds a table of results already"):
        make(tmp_path)
    (tmp_path / "table.json").unlink()
    with pytest.raises(InputError, match="holds a table of results already"):
        make(tmp_path)
    assert len(parts(tmp_path)) == 1


def test_a_folder_killed_before_its_head_was_there_is_begun_again(tmp_path):
    (tmp_path / "new" / "rows").mkdir(parents=True)
    assert make(tmp_path / "new", [row(0)]).keys() == {row(0)["key"]: "ok"}


def test_the_fixed_columns_stand_about_the_factors():
    names = [column.name for column in COLUMNS]
    assert names[:5] == ["key", "trial", "repeat", "noise_seed", "detector"]
    assert names[5:9] == [factor.name for factor in FACTORS]
    assert names[9:11] == ["status", "reason"]
    assert [column for column in COLUMNS if column not in FACTORS] == list(FIXED)


@pytest.mark.parametrize(
    ("columns", "problem"),
    [
        ((*FIXED, Column("noise_seed", "int")), "two columns are named 'noise_seed'"),
        (FIXED[1:], "no column 'key'"),
        ((Column("key", "int"), *FIXED[1:]), "no column 'key'"),
        ((*FIXED, Column("x", "list")), "kind"),
    ],
)
def test_columns_that_make_no_table_are_refused(tmp_path, columns, problem):
    with pytest.raises(ValueError, match=problem):
        Table.create(tmp_path / "new", columns, {})
    assert not (tmp_path / "new").exists()
