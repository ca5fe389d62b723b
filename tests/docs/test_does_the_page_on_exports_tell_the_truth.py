"""Are the columns that docs/export.md names there, and are all named?"""

from __future__ import annotations

import re
from pathlib import Path

from simtip.export.csv_table import BOARD_COLUMNS, NEEDLE_COLUMNS, POINT_COLUMNS

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
