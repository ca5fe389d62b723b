"""Does `simtip results` show what is in the table, and say in one line what it cannot do?"""

from __future__ import annotations

import csv
import io
import json
import math
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from asked import Answer
from sweep_tables import make, row

from simtip.cli.results import results
from simtip.detect.excerpt import printable
from simtip.errors import InputError

EVIL = "[red]x[/red] \x1b[2J\x07"


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Give 12 of 40 planned trials: two detectors, three thresholds, a fifth of them failed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    rows = [
        row(
            k,
            detector=("lin2020", "sub[b]pixel[/b]")[k % 2],
            detect__threshold=40 + k // 4,
            needle__tip__kind="cone",
            repeat=k % 2,
            error_norm_mm=None if k % 5 == 4 else k / 10,
            status="no_tip" if k % 5 == 4 else "ok",
            reason=EVIL if k % 5 == 4 else "",
        )
        for k in range(12)
    ]
    make(tmp_path / "out", rows)
    return tmp_path / "out"


@pytest.fixture
def ask(capsys):
    app = typer.Typer()
    app.command()(results)

    def call(*arguments: str) -> Answer:
        try:
            code = app(list(arguments), standalone_mode=False) or 0
        except InputError as error:
            return Answer(2, capsys.readouterr().out, str(error))
        except typer.BadParameter as error:
            return Answer(2, capsys.readouterr().out, error.format_message())
        said = capsys.readouterr()
        return Answer(code, said.out, said.err)

    return call


def lines_with(text: str, *words: str) -> list[list[str]]:
    """Give the cells of the tables' rows that begin with these words."""
    rows = [
        [cell.strip() for cell in line.strip("│┃ ").replace("┃", "│").split("│")]
        for line in text.splitlines()
    ]
    return [cells for cells in rows if cells[: len(words)] == list(words)]


def test_the_overview_tells_how_far_it_is_and_how_well_it_goes(folder, ask):
    told = ask(str(folder))
    assert (told.code, told.err) == (0, "")
    assert told.out.splitlines()[0] == f"{folder}: 12 of 40 trials known"
    assert lines_with(told.out, "ok", "10")
    assert lines_with(told.out, "no_tip", "2")
    mean = sum(k / 10 for k in (0, 2, 6, 8, 10)) / 5
    assert lines_with(told.out, "lin2020", "6", "0.833333", f"{mean:.6g}", "-")
    assert lines_with(told.out, "detect.threshold", "3", "40, 41, 42")
    assert lines_with(told.out, "detector", "2", "lin2020, sub[b]pixel[/b]")
    assert not lines_with(told.out, "needle.tip.kind"), "it does not vary"
    assert "10 of 12 trials" in told.out
    shown = ["4", "0", "lin2020", "41", "no_tip", "-", printable(EVIL)]
    assert lines_with(told.out, "4") == [shown]
    assert len(lines_with(told.out, "9")) == 1
    assert not lines_with(told.out, "11")


def test_what_a_terminal_would_obey_is_shown_instead(folder, ask, tmp_path):
    evil = tmp_path / "e[bold]vil\x1b[2J"
    folder.rename(evil)
    for arguments in ([], ["--by", "reason"], ["--where", f"reason=={EVIL}"]):
        told = ask(str(evil), *arguments)
        assert told.code == 0
        assert not set(told.out) & {"\x1b", "\x07"}
        assert r"[red]x[/red] \x1b[2J\x07" in told.out
    assert r"e[bold]vil\x1b[2J: 12 of 40 trials known, 2 of them chosen" in told.out


def test_parts_are_told_on_one_line(tmp_path, ask, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    tips = [
        {"kind": "cone", "length_mm": 5},
        {"kind": "bevel", "angle_deg": 20.5, "tip": {"kind": "round", "radius_mm": 0.1}},
        {"holes_mm": [1, 2], "sharp": True},
    ]
    texts = [json.dumps(tip, sort_keys=True) for tip in [*tips, [163, 177], {}]] + ["{none", "free"]
    made = [row(k, needle__tip__kind=text, reason="[1]") for k, text in enumerate(texts)]
    make(tmp_path / "out", made)
    said = ask(str(tmp_path / "out")).out
    for words in (
        "cone length_mm=5",
        "bevel angle_deg=20.5 tip=(round radius_mm=0.1)",
        "holes_mm=[1, 2] sharp=true",
        "[163, 177]",
        "{none",
    ):
        assert f" {words} " in said, said
    assert '"kind"' not in said
    groups = ask(str(tmp_path / "out"), "--by", "needle.tip.kind").out
    assert " cone length_mm=5 " in groups
    for written in ("cone length_mm=5", texts[0]):
        where = ["--where", f"needle.tip.kind=={written}", "--json"]
        assert [one["trial"] for one in json.loads(ask(str(tmp_path / "out"), *where).out)] == [0]
    # Others read it as it was.
    told = json.loads(ask(str(tmp_path / "out"), "--json").out)
    assert [one["needle.tip.kind"] for one in told] == texts
    table = list(csv.DictReader(io.StringIO(ask(str(tmp_path / "out"), "--csv", "-").out)))
    assert [one["needle.tip.kind"] for one in table] == texts


def test_groups_are_a_table(folder, ask):
    told = ask(
        str(folder), "--by", "detect.threshold, detector", "--stat", "count,error_norm_mm:max"
    )
    assert told.code == 0
    assert lines_with(told.out, "40", "lin2020") == [["40", "lin2020", "2", "2", "0.2"]]
    assert lines_with(told.out, "42", "sub[b]pixel[/b]") == [
        ["42", "sub[b]pixel[/b]", "2", "2", "1.1"]
    ]
    alone = ask(str(folder), "--by", "status")
    assert lines_with(alone.out, "status", "n", "detection_rate", "error_norm_mm:mean")
    assert lines_with(alone.out, "no_tip", "2", "0", "-")
    assert lines_with(ask(str(folder), "--stat", "count").out, "12", "12")


def test_conditions_sorting_and_a_limit_go_together(folder, ask):
    arguments = ["--where", "detector==lin2020", "--where", "trial<10", "--json"]
    told = json.loads(ask(str(folder), *arguments, "--sort", "error_norm_mm").out)
    assert [one["trial"] for one in told] == [0, 2, 6, 8, 4]
    told = json.loads(ask(str(folder), *arguments, "--sort", "status", "--limit", "2").out)
    assert [one["trial"] for one in told] == [4, 0]
    by = ["--by", "detector", "--stat", "error_norm_mm:min", "--sort", "error_norm_mm:min"]
    told = json.loads(ask(str(folder), *by, "--json", "--limit", "1").out)
    assert told == [{"detector": "lin2020", "n": 6, "error_norm_mm:min": 0.0}]
    assert len(lines_with(ask(str(folder), "--limit", "12").out, "11")) == 1


def test_json_has_null_for_what_is_missing_or_no_number(tmp_path, ask):
    make(tmp_path / "out", [row(0, error_norm_mm=math.inf, match__strict=True), row(1)])
    told = json.loads(ask(str(tmp_path / "out"), "--json").out, parse_constant=pytest.fail)
    assert [one["error_norm_mm"] for one in told] == [None, None]
    assert [one["match.strict"] for one in told] == [True, None]
    assert json.loads(ask(str(tmp_path / "out"), "--json", "--where", "trial<0").out) == []


def test_csv_goes_to_a_new_file_or_to_stdout(folder, ask):
    told = ask(str(folder), "--csv", "-")
    found = list(csv.DictReader(io.StringIO(told.out, newline="")))
    assert [one["trial"] for one in found] == [str(k) for k in range(12)]
    assert [one["reason"] for one in found][4] == EVIL
    written = ask(str(folder), "--csv", "all.csv")
    assert written.out == "written to all.csv: 12 rows\n"
    assert Path("all.csv").read_bytes() == told.out.encode()
    again = ask(str(folder), "--csv", "all.csv", "--by", "detector")
    assert (again.code, again.err.partition(";")[0]) == (2, "all.csv: exists")
    assert Path("all.csv").read_bytes() == told.out.encode()
    grouped = ask(str(folder), "--csv", "-", "--by", "detector", "--stat", "count")
    assert grouped.out.splitlines() == ["detector,n,count", "lin2020,6,6", "sub[b]pixel[/b],6,6"]


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--by", "detectr"], "--by: there is no column 'detectr'; did you mean 'detector'"),
        (["--by", "detector,"], "--by: 'detector,' lacks a name"),
        (["--stat", ""], "--stat: '' lacks a name"),
        (["--stat", "error_norm_mm:maen"], "did you mean 'mean'"),
        (["--where", "trial~3"], "--where: 'trial~3' is not column OP value"),
        (["--where", "trail<3"], "did you mean 'trial'"),
        (["--sort", "trail"], "--sort: there is no column 'trail'; did you mean 'trial'"),
        (
            ["--by", "detector", "--sort", "trial"],
            "--sort: there is no column 'trial'; known: dete",
        ),
        (["--json", "--csv", "-"], "--json: cannot be given with --csv"),
        (["--csv", "a.xlsx"], "a.xlsx: ends in '.xlsx'"),
        (["--csv", "none/a.csv"], "its folder does not exist"),
        (["--limit", "-1"], "greater than or equal to 0"),
    ],
)
def test_what_cannot_be_done_is_one_line(folder, ask, arguments, problem):
    told = ask(str(folder), *arguments)
    assert (told.code, told.out) == (2, "")
    assert problem in told.err
    assert "\n" not in told.err


def test_a_folder_without_a_table_is_one_line(tmp_path, ask):
    told = ask(str(tmp_path))
    assert told.code == 2
    assert told.err.endswith("holds no table of results (table.json); name the folder of a sweep")


def test_a_table_without_rows_is_shown_too(tmp_path, ask):
    make(tmp_path / "out")
    told = ask(str(tmp_path / "out"))
    assert (told.code, told.out) == (0, f"{tmp_path / 'out'}: 0 of 40 trials known\n")
    assert ask(str(tmp_path / "out"), "--by", "detector").code == 0
    assert ask(str(tmp_path / "out"), "--json").out == "[]\n"


@pytest.mark.slow
def test_the_command_alone_loads_neither_pandas_nor_pyarrow():
    code = (
        "import sys, simtip.cli.results, simtip.sweep.table, simtip.sweep.summary;"
        "print(sorted({'pandas', 'pyarrow'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
