"""Does Python's csv module read back what was written, and a spreadsheet find no formula in it?"""

from __future__ import annotations

import csv
import io
import math
import struct

import numpy as np
import pytest
from sweep_tables import COLUMNS, make, row

from simtip.sweep.csv_text import to_csv

TEXTS = ["plain", 'a "quoted", one', "two\nlines", "two\r\nlines", " spaces ", "ä🪡", "", "a;b\tc"]
FORMULAS = ["=1+1", "+49", "-1", "@SUM(A1)", "\tx", "\rx", '=HYPERLINK("http://x","y")']


def read_back(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text, newline=""), strict=True))


def test_texts_come_back_and_nothing_else_is_written(tmp_path):
    frame = make(tmp_path, [row(k, reason=text) for k, text in enumerate(TEXTS)]).frame()
    text = to_csv(frame)
    found = read_back(text)
    assert [one["reason"] for one in found] == TEXTS
    assert list(found[0]) == [column.name for column in COLUMNS]
    assert [one["lamps[0].power"] for one in found] == [""] * len(TEXTS)
    # RFC 4180: CRLF ends every line, the last too.
    assert text.endswith("\r\n")
    assert text.replace("two\r\nlines", "").count("\r\n") == len(TEXTS) + 1


def test_numbers_are_the_shortest_with_the_same_bits(tmp_path):
    rng = np.random.default_rng(1)
    drawn = np.frombuffer(rng.bytes(8 * 300), dtype=np.float64)
    numbers = [0.1, -0.0, 1 / 3, 1e22, -2.5e-310, math.inf, *drawn[np.isfinite(drawn)].tolist()]
    rows = [row(k, lamps0=None) for k in range(len(numbers))]
    for one, number in zip(rows, numbers, strict=True):
        del one["lamps0"]
        one["lamps[0].power"] = number
    cells = [one["lamps[0].power"] for one in read_back(to_csv(make(tmp_path, rows).frame()))]
    assert cells == [repr(number) for number in numbers]
    assert [struct.pack("d", float(cell)) for cell in cells] == [
        struct.pack("d", number) for number in numbers
    ]


def test_whole_numbers_and_truth_are_told_exactly(tmp_path):
    values = [(2**63 - 1, True), (-(2**63), False), (0, None), (None, True)]
    rows = [
        row(k, detect__threshold=number, match__strict=truth)
        for k, (number, truth) in enumerate(values)
    ]
    found = read_back(to_csv(make(tmp_path, rows).frame()))
    assert [one["detect.threshold"] for one in found] == [str(2**63 - 1), str(-(2**63)), "0", ""]
    assert [one["match.strict"] for one in found] == ["true", "false", "", "true"]


@pytest.mark.parametrize("formula", FORMULAS)
def test_a_formula_is_made_a_text_and_numbers_stay(tmp_path, formula):
    one = row(0, reason=formula, error_x_mm=-1.5, detect__threshold=-3)
    (found,) = read_back(to_csv(make(tmp_path, [one]).frame()))
    assert found["reason"] == f"'{formula}"
    assert (found["error_x_mm"], found["detect.threshold"]) == ("-1.5", "-3")


def test_a_name_of_a_column_is_no_formula_either(tmp_path):
    frame = make(tmp_path, [row(0)]).frame().rename(columns={"noise_seed": "=1+1"})
    assert "'=1+1" in to_csv(frame).splitlines()[0].split(",")


def test_many_rows_are_all_written(tmp_path, monkeypatch):
    monkeypatch.setattr("simtip.sweep.csv_text.CHUNK_ROWS", 7)
    found = read_back(to_csv(make(tmp_path, [row(k) for k in range(50)]).frame()))
    assert [int(one["trial"]) for one in found] == list(range(50))
    (tmp_path / "none").mkdir()
    none = to_csv(make(tmp_path / "none").frame())
    assert none.count("\r\n") == 1
    assert read_back(none) == []
