"""Is a table as it was, with nothing left behind, when a write fails?"""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from sweep_tables import COLUMNS, PROVENANCE, left_over, make, parts, row

from simtip.errors import InputError
from simtip.sweep import parts as parts_module
from simtip.sweep.table import Table

# SIGXFSZ is ignored by Python, so a write beyond the limit fails as on a full disk.
FULL = """
import resource, sys
from pathlib import Path
sys.path[:0] = [sys.argv[2]]
from sweep_tables import COLUMNS, row
from simtip.sweep import parts as parts_module, table as module

parts_module.MERGE_ABOVE = 1
table = module.Table.open(Path(sys.argv[1]))
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
many = [row(k, reason=row(k + 10**6)["key"]) for k in range(2000)]
calls = {
    "append": lambda: table.append(many),
    "compact": table.compact,
    "rewrite": lambda: table.rewrite(COLUMNS, [many[:10], many], {}),
}
for name, call in calls.items():
    try:
        call()
    except OSError as error:
        print(name, error.errno)
table.append([row(-1)])
"""


def content(folder: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="limits the size of files")
def test_a_real_write_that_fails_leaves_the_table_as_it_was(tmp_path):
    table = make(tmp_path, [row(k, reason=row(k + 5000)["key"]) for k in range(200)])
    table.append([row(k, reason=row(k + 6000)["key"]) for k in range(200, 400)])
    before = content(tmp_path)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", FULL, tmp_path, Path(__file__).parent],
        capture_output=True,
        text=True,
        check=True,
    )
    said = [f"{name} {errno.EFBIG}" for name in ("append", "compact", "rewrite")]
    assert done.stdout.splitlines() == said
    assert done.stderr == ""
    after = content(tmp_path)
    assert {name: after.get(name) for name in before} == before
    assert len(after) == len(before) + 1, "the small part that came last, and nothing else"
    assert not left_over(tmp_path)
    assert len(table.frame()) == 401


@pytest.mark.parametrize("step", ["fsync", "replace"])
@pytest.mark.parametrize("call", ["append", "compact", "rewrite"])
def test_a_failure_at_any_step_is_cleaned_up(tmp_path, monkeypatch, step, call):
    table = make(tmp_path, [row(0)])
    table.append([row(1)])
    monkeypatch.setattr(parts_module, "MERGE_ABOVE", 1)
    before = content(tmp_path)

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    calls = {
        "append": lambda: table.append([row(2)]),
        "compact": table.compact,
        "rewrite": lambda: table.rewrite(COLUMNS, [[row(2)]], {}),
    }
    with monkeypatch.context() as patch:
        patch.setattr(os, step, full)
        with pytest.raises(OSError, match="No space left"):
            calls[call]()
    assert content(tmp_path) == before
    assert not left_over(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rows", "table.json"]
    assert table.provenance == PROVENANCE
    table.append([row(3)])
    assert len(table.frame()) == 3
    assert len(parts(tmp_path)) == 3


def test_a_table_that_cannot_be_begun_is_one_line(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("x")
    for folder in (tmp_path / "file", tmp_path / "file" / "inside"):
        with pytest.raises(InputError, match="cannot be written"):
            Table.create(folder, COLUMNS, {})

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match=r"new: cannot be written \(No space left on device\)"):
        Table.create(tmp_path / "new", COLUMNS, {})
    assert not left_over(tmp_path)
