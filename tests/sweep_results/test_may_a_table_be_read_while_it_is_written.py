"""Does a reader see whole tables, while another process appends, merges and replaces?"""

from __future__ import annotations

from pathlib import Path

import pytest
from sweep_tables import COLUMNS, make, parts, row, started

from simtip.sweep import parts as parts_module
from simtip.sweep import table as table_module
from simtip.sweep.table import Table

APPENDING = """
import sys
from pathlib import Path
sys.path[:0] = [sys.argv[2]]
from sweep_tables import row
from simtip.sweep import parts as parts_module, table as module

parts_module.MERGE_ABOVE, parts_module.PART_ROWS, parts_module.BATCH_ROWS = 4, 500, 20
table = module.Table.open(Path(sys.argv[1]))
print("ready", flush=True)
sys.stdin.readline()
for k in range(0, 100, 2):
    # Each row comes twice, so that a merging has something to leave out.
    table.append([row(max(k - 2, 0), status="again"), row(k), row(k + 1)])
    print(k + 2, flush=True)
    table.compact()
"""

REPLACING = """
import sys
from pathlib import Path
sys.path[:0] = [sys.argv[2]]
from sweep_tables import COLUMNS, row
from simtip.sweep import parts as parts_module, table as module

parts_module.PART_ROWS, parts_module.BATCH_ROWS = 10, 10
table = module.Table.open(Path(sys.argv[1]))
print("ready", flush=True)
sys.stdin.readline()
for edition in range(1, 16):
    rows = ([row(k + j, repeat=edition) for j in range(5)] for k in range(0, 40, 5))
    table.rewrite(COLUMNS, rows, {"edition": edition})
    print(edition, flush=True)
"""


def talk(code, folder):
    """Start a writer, which waits for a line before it writes, and says what it has written."""
    process = started(code, folder, Path(__file__).parent)
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.slow
def test_no_row_is_missing_or_double_while_parts_are_merged(tmp_path):
    make(tmp_path)
    process = talk(APPENDING, tmp_path)
    table = Table.open(tmp_path)
    process.stdin.write("go\n")
    process.stdin.flush()
    numbers = {row(k)["key"]: k for k in range(100)}
    seen, reads = set(), 0
    while process.poll() is None or not reads:
        written = int(process.stdout.readline() or 100)
        found = {numbers[key] for key, _ in table.keys().items()}
        assert found >= set(range(written)) | seen, "what was written before is not there"
        frame = table.frame()
        assert frame["key"].is_unique
        assert frame["trial"].is_monotonic_increasing
        seen, reads = set(frame["trial"]), reads + 1
        assert seen >= found
    process.communicate()
    assert process.returncode == 0
    assert reads > 5
    assert len(table.frame()) == len(table.keys()) == 100
    assert len(parts(tmp_path)) < 10


@pytest.mark.slow
def test_a_table_that_is_replaced_is_the_old_one_or_the_new_one(tmp_path):
    make(tmp_path, [row(k, repeat=0) for k in range(40)])
    process = talk(REPLACING, tmp_path)
    table = Table.open(tmp_path)
    process.stdin.write("go\n")
    process.stdin.flush()
    editions = []
    while process.poll() is None:
        frame = table.frame()
        assert list(frame["trial"]) == list(range(40))
        assert frame["repeat"].nunique() == 1, "rows of two tables in one"
        editions.append(int(frame["repeat"].iloc[0]))
        assert len(table.keys()) == 40
    process.communicate()
    assert process.returncode == 0
    assert editions == sorted(editions)
    assert len(set(editions)) > 2
    assert set(table.frame()["repeat"]) == {15}


@pytest.mark.parametrize("read", ["frame", "keys"])
def test_a_part_that_vanishes_after_it_was_listed_is_looked_for_anew(tmp_path, monkeypatch, read):
    """The same in slow motion, as it would happen rarely."""
    table = make(tmp_path, [row(0)])
    for k in range(1, 6):
        table.append([row(k)])
    listed = table_module.parts_in

    def then_merged(folder):
        found = listed(folder)
        if len(found) > 1:
            monkeypatch.setattr(table_module, "parts_in", listed)
            parts_module.merge(found, table._head.schema())
        return found

    monkeypatch.setattr(table_module, "parts_in", then_merged)
    assert len(getattr(table, read)()) == 6
    assert len(parts(tmp_path)) == 1


@pytest.mark.parametrize("read", ["frame", "keys"])
def test_a_table_replaced_before_it_was_listed_is_not_half_seen(tmp_path, monkeypatch, read):
    """The old parts go one by one: a list of them may be short without anything missing."""
    table = make(tmp_path, [row(0)])
    table.append([row(1)])
    listed = table_module.parts_in

    def then_replaced(folder):
        monkeypatch.setattr(table_module, "parts_in", listed)
        found = listed(folder)[:1]
        stay = monkeypatch.context()
        with stay as patch:
            patch.setattr(table_module.shutil, "rmtree", lambda *_, **__: None)
            Table.open(tmp_path).rewrite(COLUMNS, [[row(7), row(8), row(9)]], {})
        return found

    monkeypatch.setattr(table_module, "parts_in", then_replaced)
    assert len(getattr(table, read)()) == 3
