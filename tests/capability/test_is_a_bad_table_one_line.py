"""Is whatever is wrong with a table said in one line, with file, line, field and remedy?"""

from __future__ import annotations

import re

import numpy as np
import pytest
from asked import call

from simtip.capability.table import read_table
from simtip.errors import InputError

GOOD = "part,operator,trial,reference,measured\n"
ROWS = "".join(
    f"{p},{o},{t},{p},{p + 0.1 * t + 0.01 * p * t}\n" for p in (1, 2) for o in "xy" for t in (1, 2)
)

CASES = {
    "empty file": ("", ": is empty"),
    "only blank": ("\n\n", ":1: has a header at most, and no row"),
    "only header": ("reference,measured\n", ":1: has a header at most"),
    "no measured": (
        "reference,vision\n1,2\n",
        (
            ":1: measured: there is no column 'measured'; the "
            "header has 'reference', 'vision': say --column measured=HEADER"
        ),
    ),
    "measured twice": ("measured,Measured,measured\n1,2,3\n", ":1: measured: there are 2 columns"),
    "missing": ("reference,measured\n1,1.1\n2,\n3,3\n", ":3: measured: the value is missing; fill"),
    "missing label": ("part,measured\na,1\n,2\nb,3\n", ":3: part: the value is missing"),
    "text": ("reference,measured\n1,1.1\n2,two\n3,3\n", ":3: measured: 'two' is no number"),
    "unit": ("reference,measured\n1,1.1 mm\n2,2\n3,3\n", ":2: measured: '1.1 mm' is no number"),
    "nan": ("reference,measured\n1,1.1\n2,nan\n3,3\n", ":3: measured: 'nan' is not finite"),
    "inf": ("reference,measured\n1,1.1\n-inf,2\n3,3\n", ":3: reference: '-inf' is not finite"),
    "overflow": ("measured\n1\n1e400\n3\n", ":3: measured: '1e400' is larger than 1e+30"),
    "python number": ("measured\n1\n1_0\n3\n", ":3: measured: '1_0' is no number"),
    "other digits": ("measured\n1\n\u0661\n3\n", ":3: measured: '\u0661' is no number"),
    "formula": ("measured\n1\n=1+1\n3\n", ":3: measured: '=1+1' is no number"),
    "decimal comma": (
        "reference;measured\n1;1,1\n2;2\n3;3\n",
        (":2: measured: '1,1' has a decimal comma; write a decimal point"),
    ),
    "decimal comma, quoted": ('reference,measured\n1,"1,1"\n2,2\n', ":2: measured: '1,1' has a"),
    "decimal commas between commas": (
        "reference,measured\n1,0,1,1\n",
        (":2: has 4 cells, and the header 2; give every row one cell a column, with a decimal"),
    ),
    "cell too few": ("reference,measured\n1,1\n2\n", ":3: has 1 cells, and the header 2"),
    "bad quotes": ('reference,measured\n1,1\n2,"2"x\n', ":3: is no CSV"),
    "open quotes": ('reference,measured\n1,1\n2,"2\n3,3\n', ":3: is no CSV"),
    "two rows": ("reference,measured\n1,1\n2,2.5\n", ":3: measured: 2 rows are too few"),
    "measured constant": (
        "reference,measured\n1,2\n2,2\n3,2\n",
        (":2: measured: all values, to line 4, are 2: nothing varies"),
    ),
    "reference constant": ("reference,measured\n2,1\n2,2\n2,3\n", ":2: reference: all values, to"),
    "same trial": (
        GOOD + ROWS + "2,y,2,2,2.2\n",
        (":10: trial: part '2', operator 'y', trial '2' is on line 9 already"),
    ),
    "missing cell": (
        GOOD + ROWS.replace("2,x,1,2,2.12\n", "").replace("2,x,2,2,2.24\n", ""),
        (
            ":6: part: operator 'x' measured part '2' 0 times, others were measured 2 "
            "times: gauge R&R needs equal numbers"
        ),
    ),
    "unbalanced": (
        GOOD + ROWS.replace("2,y,2,2,2.24\n", ""),
        (":6: part: operator 'y' measured part '2' once, others"),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_it_is_one_line_and_exit_code_2(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text, problem = CASES[name]
    (tmp_path / "m.csv").write_text(text, encoding="utf-8")
    told = call("mca", "--csv", "m.csv", "--json")
    assert (told.code, told.out) == (2, "")
    assert told.err.startswith(f"simtip: m.csv{problem}"), told.err
    assert told.err.count("\n") == 1
    assert "; " in told.err  # a remedy


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"measured\n1\n\xff\n", ":3: is not UTF-8 text"),
        ("measured\n1\n2\n".encode("utf-16"), ":1: is not UTF-8 text"),
        (b"measured\n1\n\x00\n", ":3: is no text"),
        (b"\x80\x04\x95pickle", ":1: is not UTF-8 text"),
    ],
)
def test_what_is_no_text_is_not_read(content, problem, tmp_path):
    (tmp_path / "m.csv").write_bytes(content)
    told = call("mca", "--csv", str(tmp_path / "m.csv"))
    assert told.code == 2
    assert f"m.csv{problem}" in told.err


def test_what_is_no_file_is_said(tmp_path):
    assert "no such file" in call("mca", "--csv", str(tmp_path / "none.csv")).err
    assert "is a folder" in call("mca", "--csv", str(tmp_path)).err


OPTIONS = [
    (["--level", "95"], "--level: is 95, and not between 0.5 and 0.9999; 0.95 is 95 %"),
    (["--level", "nan"], "--level: is nan"),
    (["--tolerance", "0"], "--tolerance: is 0; give"),
    (["--tolerance", "inf"], "--tolerance: is inf; give"),
    (["--multiplier", "-6"], "--multiplier: is -6; give"),
    (["--column", "reference"], "--column: 'reference' is not NAME=HEADER; NAME is one of"),
    (["--column", "refrence=a"], "--column: 'refrence=a' is not NAME=HEADER"),
    (["--column", "part=a", "--column", "part=b"], "--column: part is there twice"),
    (["--column", "part=nowhere"], "m.csv:1: part: there is no column 'nowhere'"),
    (["--column", "part=measured"], "m.csv:1: measured: is said to be both"),
    (["--repeated", "varies"], "m.csv:2: --repeated: there is no column part"),
    (["--repeated", "sometimes"], "'sometimes' is not one of"),
    (["--readings", "angle"], "'angle' is not one of"),
]


@pytest.mark.parametrize(("options", "problem"), OPTIONS)
def test_a_bad_option_is_one_line(options, problem, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.csv").write_text("reference,measured\n1,1\n2,2.1\n3,3\n")
    told = call("mca", "--csv", "m.csv", *options)
    assert (told.code, told.out) == (2, "")
    assert problem in told.err
    assert told.err.count("\n") == 1


def test_repeated_pairs_that_are_not_repeated_are_refused(tmp_path):
    (tmp_path / "m.csv").write_text("part,reference,measured\na,1,1\nb,2,2.1\nc,3,3\n")
    told = call("mca", "--csv", str(tmp_path / "m.csv"), "--repeated", "constant")
    assert "m.csv:2: part: repeated pairs need two parts" in told.err


VALUES = "2.0,2.25\n4.0,4.5\n6.0,6.125\n"
FORMS = {
    "commas": "reference,measured\n" + VALUES,
    "semicolons": ("reference,measured\n" + VALUES).replace(",", ";"),
    "tabs": ("reference,measured\n" + VALUES).replace(",", "\t"),
    "byte order mark": "\ufeffreference,measured\n" + VALUES,
    "line ends of Windows": ("reference,measured\n" + VALUES).replace("\n", "\r\n"),
    "line ends of old": ("reference,measured\n" + VALUES).replace("\n", "\r"),
    "blank lines and blanks": "\n reference , Measured \n\n" + VALUES.replace(",", " , ") + "\n,\n",
    "quotes": 'reference,measured\n"2.0","2.25"\n4.0,4.5\n6.0,6.125',
    "empty cells at the end": "reference,measured\n" + VALUES.replace("\n", ",,\n"),
    "other columns": "note,measured,reference\n"
    + "".join(f'"a,\nb",{m},{r}\n' for r, m in ((2, 2.25), (4, 4.5), (6, 6.125))),
    "signs and exponents": "reference,measured\n+2,225e-2\n4.,.45E1\n6,6.125\n",
}


@pytest.mark.parametrize("name", FORMS)
def test_every_usual_form_is_read_alike(name, tmp_path):
    path = tmp_path / "m.csv"
    path.write_bytes(FORMS[name].encode())
    found = read_table(path)
    assert found.reference.tolist() == [2, 4, 6]
    assert found.measured.tolist() == [2.25, 4.5, 6.125]


def test_lines_are_counted_through_quotes_and_blanks(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text('note,measured\n"a\nb\nc",1\n\nx,2\n\n"d\ne",oops\n')
    with pytest.raises(InputError, match=re.escape("m.csv:8: measured: 'oops' is no number")):
        read_table(path)
    path.write_text('note,measured\n"a\nb\nc",1\n\nx,2\n')
    assert read_table(path).lines == (2, 6)


def test_a_name_like_a_formula_or_a_code_of_the_terminal_does_nothing(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text("part,measured\n=cmd()\x1b[2J[red],1\n=cmd()\x1b[2J[red],2\nb,3\n")
    told = call("mca", "--csv", str(path))
    assert told.code == 0
    assert "\x1b" not in told.out
    path.write_text("part,trial,measured\n\x1b[2Ja,1,1\n\x1b[2Ja,1,2\nb,1,3\n")
    told = call("mca", "--csv", str(path))
    assert told.code == 2
    assert "\x1b" not in told.err


@pytest.mark.slow
def test_a_large_table_is_read_in_seconds(tmp_path):
    values = np.random.default_rng(0).normal(10, 1, 50_000)
    path = tmp_path / "m.csv"
    path.write_text("reference,measured\n" + "".join(f"{v},{v + 0.1 * v**0.5}\n" for v in values))
    told = call("mca", "--csv", str(path), "--json")
    assert told.code == 0, told.err
