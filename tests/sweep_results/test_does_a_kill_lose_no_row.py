"""Whatever moment a writer is killed at: is every row there that it was told is written?"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from sweep_tables import COLUMNS, left_over, make, parts, row, started

from simtip.sweep import parts as parts_module
from simtip.sweep.table import Table

pytestmark = pytest.mark.skipif(os.name != "posix", reason="sends SIGKILL")

# Forks a writer for each kill, which comes so many seconds after so many of its writes.
KILLING = """
import os, signal, sys, time
from pathlib import Path
import pandas, pyarrow.parquet  # now, so that the writer loads nothing
sys.path[:0] = [sys.argv[2]]
from sweep_tables import COLUMNS, row
from simtip.sweep import parts as parts_module, table as module

parts_module.MERGE_ABOVE, parts_module.PART_ROWS, parts_module.BATCH_ROWS = 4, 60, 7
folder, log = Path(sys.argv[1]), os.open(sys.argv[3], os.O_WRONLY | os.O_APPEND | os.O_CREAT)

def told(number):
    os.write(log, f"{number}\\n".encode())
    os.write(writing, b"x")

def append(first):
    table = module.Table.open(folder)
    for k in range(first, first + 3000, 3):
        table.append([row(k), row(k + 1), row(k + 2)])
        told(k)
        table.compact()

def replace(first):
    table = module.Table.open(folder)
    for edition in range(table.provenance["edition"] + 1, 10**6):
        rows = ([row(k + j, repeat=edition) for j in range(20)] for k in range(0, 100, 20))
        table.rewrite(COLUMNS, rows, {"edition": edition})
        told(edition)

write = {"append": append, "replace": replace}[sys.argv[4]]
for line in sys.stdin:
    number, writes, delay = line.split()
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            write(int(number) * 3000)
        finally:
            os._exit(1)
    for _ in range(int(writes)):
        os.read(reading, 1)
    time.sleep(float(delay))
    os.kill(child, signal.SIGKILL)
    print(os.waitpid(child, 0)[1], flush=True)
"""


class Killer:
    """Has a writer killed after some writes and seconds; gives what it knew to be written."""

    def __init__(self, folder: Path, what: str) -> None:
        self.log = folder / "log"
        here = Path(__file__).parent
        self.process = started(KILLING, folder / "out", here, self.log, what)

    def __call__(self, number: int, writes: int, delay_s: float) -> list[int]:
        self.process.stdin.write(f"{number} {writes} {delay_s}\n")
        self.process.stdin.flush()
        assert self.process.stdout.readline() == "9\n", "the writer ended by itself"
        return [int(line) for line in self.log.read_text().splitlines()]


@pytest.fixture
def killer(tmp_path):
    killers = []

    def start(what: str) -> Killer:
        killers.append(Killer(tmp_path, what))
        return killers[-1]

    yield start
    for one in killers:
        one.process.communicate(timeout=20)


@pytest.mark.slow
def test_appended_rows_outlive_a_kill(tmp_path, killer):
    folder = tmp_path / "out"
    make(folder)
    kill = killer("append")
    rng = np.random.default_rng(8)
    for number in range(20):
        told = kill(number, rng.integers(1, 8), rng.uniform(0, 0.02))
        table = Table.open(folder)
        frame = table.frame()
        rows = set(frame["trial"])
        assert rows >= {k + j for k in told for j in range(3)}, "a row is lost"
        # Of what was being written when the kill came, all or nothing is there.
        assert {k // 3 for k in rows} >= {k // 3 for k in told}
        assert len(rows) % 3 == 0
        assert len(rows) <= 3 * (len(told) + number + 1)
        assert frame["key"].is_unique
        assert set(table.keys()) == set(frame["key"])
    assert len(told) >= 20
    table.append([row(10**6)])
    assert not left_over(folder)
    assert len(table.frame()) == len(rows) + 1


@pytest.mark.slow
def test_a_replaced_table_is_old_or_new_after_a_kill(tmp_path, killer):
    folder = tmp_path / "out"
    rows = [row(k, repeat=0) for k in range(100)]
    table = Table.create(folder, COLUMNS, {"edition": 0})
    table.append(rows)
    kill = killer("replace")
    rng = np.random.default_rng(9)
    for number in range(12):
        told = kill(number, rng.integers(0, 3), rng.uniform(0, 0.04))
        table = Table.open(folder)
        frame = table.frame()
        assert list(frame["trial"]) == list(range(100))
        assert set(frame["repeat"]) == {table.provenance["edition"]}
        last = told[-1] if told else 0
        assert table.provenance["edition"] in range(last, last + number + 2)
    assert told[-1] >= 5
    table.append([row(100)])
    assert not left_over(folder)
    assert len(list(folder.glob("rows*"))) == 1


def test_a_kill_between_merging_and_removing_doubles_nothing(tmp_path, monkeypatch):
    table = make(tmp_path, [row(0, status="old"), row(1, status="old")])
    table.append([row(1, status="new"), row(2)])
    table.append([row(3)])

    def killed(*_, **__):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(parts_module, "MERGE_ABOVE", 1)
        patch.setattr(Path, "unlink", killed)
        with pytest.raises(KeyboardInterrupt):
            table.compact()
    assert len(parts(tmp_path)) == 3, "nothing was merged, or all was removed"
    after = Table.open(tmp_path)
    expected = {row(0)["key"]: "old", row(1)["key"]: "new", row(2)["key"]: "ok"}
    expected[row(3)["key"]] = "ok"
    assert after.keys() == expected
    frame = after.frame()
    assert dict(zip(frame["key"], frame["status"], strict=True)) == expected
    assert len(frame) == 4
    monkeypatch.setattr(parts_module, "MERGE_ABOVE", 1)
    after.compact()
    assert len(parts(tmp_path)) == 1
    assert after.keys() == expected


def test_old_parts_go_only_when_the_merged_one_is_on_the_disk(tmp_path, monkeypatch):
    """The power may fail, too: no test can wait for that, so the order of calls is checked."""
    table = make(tmp_path, [row(0)])
    table.append([row(1)])
    monkeypatch.setattr(parts_module, "MERGE_ABOVE", 1)
    calls = []
    real = {name: getattr(os, name) for name in ("fsync", "replace", "unlink")}

    def noted(name):
        def call(*arguments, **more):
            calls.append(name)
            return real[name](*arguments, **more)

        return call

    for name in real:
        monkeypatch.setattr(os, name, noted(name))
    table.compact()
    assert calls == ["fsync", "replace", "fsync", "unlink"]
