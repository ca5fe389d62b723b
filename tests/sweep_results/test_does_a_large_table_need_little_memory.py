"""Do the calls for large tables work, and hold only what they have to?"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from sweep_tables import started

COUNT = 100_000

# Random reasons, which no compression makes small: to hold all rows would need their room.
COMMON = """
import json, random, sys
from pathlib import Path
import pandas, pyarrow.parquet
sys.path[:0] = [sys.argv[2]]
from sweep_tables import COLUMNS, make, row
from simtip.sweep import parts as parts_module, table as module

COUNT, LONG = int(sys.argv[3]), 300
folder = Path(sys.argv[1])

def rows(first, count):
    text = random.Random(first).randbytes(LONG * count).hex()
    return [
        row(k, reason=text[2 * LONG * j : 2 * LONG * (j + 1)], error_norm_mm=k / 7)
        for j, k in enumerate(range(first, first + count))
    ]
"""

FILL = f"""{COMMON}
table = make(folder)
for first in range(0, COUNT, 5000):
    table.append(rows(first, 5000))
print("{{}}")
"""

# The peak is what a process ever needed: the calls come in order of what they may need.
CALLS = f"""{COMMON}
def peak():
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmHWM:")[2].split()[0]) / 1024

parts_module.BATCH_ROWS, parts_module.MERGE_ABOVE = 2000, 4
make(folder.parent / "warm", rows(0, 1)).frame()  # loads what is loaded late
table = module.Table.open(folder)
peaks = [peak()]
count = len(table.keys())
peaks.append(peak())
table.compact()
merged = len(list(folder.glob("rows/part-*")))
peaks.append(peak())
table.rewrite(COLUMNS, table.batches(), {{}})
peaks.append(peak())
frame = table.frame()
peaks.append(peak())
more = [later - peaks[0] for later in peaks[1:]]
last = float(frame["error_norm_mm"].iloc[-1])
found = {{"keys": count, "merged": merged, "rows": len(frame), "last": last, "mib": more}}
print(json.dumps(found))
"""


def told(code: str, folder: Path) -> dict:
    process = started(code, folder, Path(__file__).parent, COUNT)
    out, _ = process.communicate(timeout=120)
    assert process.returncode == 0
    return json.loads(out)


@pytest.mark.slow
@pytest.mark.skipif("sys.platform != 'linux'", reason="memory is read from /proc")
def test_a_hundred_thousand_rows(tmp_path):
    """The reasons alone are 60 MB."""
    told(FILL, tmp_path / "out")
    found = told(CALLS, tmp_path / "out")
    assert (found["keys"], found["rows"], found["merged"]) == (COUNT, COUNT, 1)
    assert found["last"] == (COUNT - 1) / 7
    keys, compact, rewrite, frame = found["mib"]
    assert keys < 80, found
    assert compact < 125, found
    assert rewrite < 190, found
    assert rewrite < frame < 600, found
