"""Do the commands of docs/export.md work as written, and are the columns it names there?"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from boards.board_scenes import small as small_boards
from export.exported import run_into, small
from sweep.small_sweeps import run, sweep_file

from simtip.boards import plan_boards
from simtip.boards_folder import fill_folder
from simtip.export.csv_table import BOARD_COLUMNS, NEEDLE_COLUMNS, POINT_COLUMNS
from simtip.render import choose

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "export.md").read_text(encoding="utf-8")


def named_columns(text: str) -> set[str]:
    return set(re.findall(r"`([A-Za-z_0-9]+)`", text))


def test_every_column_that_the_page_names_is_there():
    part = PAGE.partition("## csv")[2].partition("## simtip view")[0]
    table, _, boards = part.partition("Of boards:")
    known = {*NEEDLE_COLUMNS, "trial", "repeat", "noise_seed"}
    short = {"k2", "p1", "p2", "k3", "k4", "k5", "k6"}  # after left_k1
    assert named_columns(table.partition("| columns | what |")[2]) - short <= known
    assert short <= {name.removeprefix("left_") for name in NEEDLE_COLUMNS}
    views = {"R", "T"}  # of the table above
    assert named_columns(boards) - views <= {*BOARD_COLUMNS, *POINT_COLUMNS}


def test_every_column_is_told_of():
    """By its name without side, axis and index."""
    part = PAGE.partition("## csv")[2].partition("## simtip view")[0]
    for name in NEEDLE_COLUMNS:
        stem = re.sub(r"^(left|right)_", "", name)
        stem = re.sub(r"_[uvxyz](_px|_mm)?$|\d+$", "", stem)
        assert stem in part, name


@pytest.mark.slow
def test_the_commands_run_as_written(tmp_path, monkeypatch, scene, ask):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SIMTIP_CACHE", str(tmp_path / "cache"))
    Path("out").mkdir()
    run_into(Path("out/demo"), small(scene))
    boards = plan_boards(small_boards(scene, views=2))
    fill_folder(Path("out/boards"), boards, backend=choose("llvm"), progress=lambda _: None)
    file = sweep_file(tmp_path, factors={"detect.threshold": [60, 120]})
    run(file, Path("out/swept"), "--workers", "1")
    block = re.search(r"^```sh\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)[1]
    lines = [shlex.split(line, comments=True) for line in block.splitlines()]
    assert len(lines) == 5
    for program, *arguments in lines:
        assert program == "simtip"
        answer = ask(*arguments)
        assert answer.code == 0, answer.err
