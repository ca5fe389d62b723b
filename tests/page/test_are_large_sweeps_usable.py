"""A hundred thousand trials: is the page small, and soon there?"""

from __future__ import annotations

import math
import time

import numpy as np
import pandas as pd
import pytest
from made_tables import row, written

from simtip.sweep.columns import Column, columns_for
from simtip.sweep.table import Table

pytestmark = pytest.mark.slow

TRIALS = 100_000
MOST_BYTES = 15_000_000
MOST_S = 3.0


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """Four factors, twenty repeats, noise in every number: nothing of it packs well."""
    folder = tmp_path_factory.mktemp("large") / "sweep"
    rng = np.random.default_rng(5)
    names = ["detect.threshold", "lamps[0].power", "needle.roll_deg", "sensor.gain"]
    sizes = [25, 20, 5, 2]
    kinds = ["int", "float", "float", "float"]
    place = np.stack(np.unravel_index(np.arange(TRIALS) // 20, sizes))
    errors = rng.gamma(3, 0.02 + 0.002 * place[0], TRIALS)
    lost = rng.random(TRIALS) < place[1] / 100
    signs = rng.normal(size=(8, TRIALS))
    table = Table.create(
        folder,
        columns_for(Column(n, k) for n, k in zip(names, kinds, strict=True)),
        {"trials": TRIALS},
    )
    plain = row(0)
    for start in range(0, TRIALS, 20_000):
        rows = []
        for k in range(start, start + 20_000):
            one = (
                row(k, None if lost[k] else float(errors[k]))
                if lost[k]
                else {**plain, "key": f"{k:032x}"}
            )
            if not lost[k]:
                one["error_norm_mm"] = float(errors[k])
                for n, name in enumerate(
                    (
                        *(f"error_{a}_mm" for a in "xyz"),
                        *(
                            f"{s}_error_{w}_px"
                            for s in ("left", "right")
                            for w in ("along", "across")
                        ),
                    )
                ):
                    one[name] = float(errors[k] * signs[n, k])
            else:
                one["reason"] = f"left: the lowest edge is {k % 977} px from the border"
            values = zip(names, kinds, place[:, k], strict=True)
            one |= {name: int(v) if kind == "int" else float(v) * 0.37 for name, kind, v in values}
            rows.append(one | {"trial": k, "repeat": k % 20, "detect_s": float(abs(signs[7, k]))})
        table.append(rows)
    return folder


def test_it_is_made_small_and_there_within_seconds(large, opened, record_property):
    start = time.perf_counter()
    file = written(large)
    made_s = time.perf_counter() - start
    size = file.stat().st_size
    start = time.perf_counter()
    with opened(file) as page:
        ready_s = time.perf_counter() - start
        record_property("bytes", size)
        record_property("made_s", made_s)
        record_property("ready_s", ready_s)
        assert size < MOST_BYTES
        assert ready_s < MOST_S
        assert made_s < 60
        heap = page.evaluate("performance.memory ? performance.memory.usedJSHeapSize : 0")
        assert heap < 200e6
        start = time.perf_counter()
        page.locator("[aria-label='Only trials with']").fill("error_norm_mm<0.1")
        frame = Table.open(large).frame()
        expected = int((frame["error_norm_mm"] < 0.1).sum())
        shown = f"{expected:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")
        page.wait_for_function(
            "text => document.querySelector('.pager span').textContent.endsWith(text)",
            arg=f" of {shown} trials",
        )
        assert time.perf_counter() - start < MOST_S


def test_more_than_a_page_holds_is_said(tmp_path, monkeypatch):
    from made_tables import make, page

    from simtip.page import explorer

    monkeypatch.setattr(explorer, "MOST_ROWS", 100)
    monkeypatch.setattr("simtip.page.sweep.MOST_ROWS", 100)
    rows = [row(k, 0.1 + k) for k in range(250)]
    text = page(make(tmp_path / "sweep", [], rows))
    assert "drawn by lot: 150 are left out" in text
    assert "A tip was found in 250 of 250 trials" in text


def test_columns_come_back_as_they_were():
    """The packed table, read by plain Python."""
    import json
    import struct

    from simtip.page.columns import codes, numbers, packed

    frame = pd.DataFrame(
        {
            "x": pd.array([1.5, None, -2.25, math.inf], dtype="float64"),
            "n": pd.array([3, None, 2**40, -1], dtype="Int64"),
            "t": pd.array(["b", None, "a", "b"], dtype="string"),
        }
    )
    data = packed(
        [numbers("x", frame["x"], "mm"), codes("n", frame["n"]), codes("t", frame["t"])], 4
    )
    (length,) = struct.unpack("<I", data[:4])
    head = json.loads(data[4 : 4 + length])
    x, n, t = (np.frombuffer(data, f"<{one['type']}", 4, one["offset"]) for one in head["columns"])
    assert all(one["offset"] % 8 == 0 for one in head["columns"])
    np.testing.assert_array_equal(x, np.array([1.5, np.nan, -2.25, np.nan], np.float32))
    huge = numbers("x", pd.Series([1e300]))
    assert huge.cells[0] == 1e300
    assert [head["columns"][1]["numbers"][k] for k in n] == [3.0, None, 2.0**40, -1.0]
    assert [head["columns"][2]["levels"][k] for k in t] == ["b", "\N{EN DASH}", "a", "b"]
