"""Sweeps that are odd: at work, all failed, without factors, with many, with nothing."""

from __future__ import annotations

import math
import re

import pytest
from made_tables import make, page, row, written

from simtip.page.folder import results_in
from simtip.page.make import page_of
from simtip.page.options import Options


def text_of(html: str) -> str:
    head = html.split("<main", maxsplit=1)[0].split("<h1>", maxsplit=1)[1]
    return re.sub(r"[ \n]+", " ", re.sub(r"<[^>]+>", " ", head))


def test_a_running_sweep_says_how_far_it_is(tmp_path):
    rows = [row(k, 0.1, **{"detect.threshold": 60 + k}) for k in range(3)]
    folder = make(tmp_path / "sweep", [("detect.threshold", "int")], rows, planned=2000)
    assert "3 of 2\N{NARROW NO-BREAK SPACE}000 trials are known" in text_of(page(folder))


def test_a_sweep_without_rows_has_a_page(tmp_path):
    folder = make(tmp_path / "sweep", [("detect.threshold", "int")], [], planned=5)
    html = page(folder)
    assert "0 of 5 trials are known" in html
    assert 'class="explorer"' not in html


def failed(k):
    return row(k, None, **{"detect.threshold": 60 + k})


CASES = {
    "all failed": ([("detect.threshold", "int")], [failed(k) for k in range(4)]),
    "no factors": ([], [row(k, 0.1 + 0.01 * k, repeat=k) for k in range(5)]),
    "one trial": ([], [row(0, 0.1)]),
    "one failed trial": ([], [row(0, None)]),
    "eight factors": (
        [(f"f{n}", "float") for n in range(8)],
        [row(k, 0.1, **{f"f{n}": float(k >> n & 1) for n in range(8)}) for k in range(256)],
    ),
    "text factors": (
        [("needle.tip", "text"), ("rig.measured", "text")],
        [
            row(
                k,
                0.1 * k,
                **{"needle.tip": '{"kind": "cone"}' if k % 2 else "x", "rig.measured": m},
            )
            for k, m in enumerate(["a", "b", None, "a"])
        ],
    ),
    "numbers missing": (
        [("lamps[0].power", "float"), ("flag", "bool")],
        [row(k, math.nan if k % 2 else 1.0, flag=None if k else True) for k in range(4)],
    ),
    "spread over a range": (
        [("lamps[0].power", "float"), ("needle.roll_deg", "float")],
        [
            row(
                k,
                0.1 + k * 1e-5,
                **{"lamps[0].power": 10 ** (k / 900), "needle.roll_deg": k * 7 % 360.0},
            )
            for k in range(2500)
        ],
    ),
    "infinite errors": ([("f", "int")], [row(k, math.inf if k else 0.1, f=k) for k in range(3)]),
}


@pytest.mark.parametrize("case", CASES)
def test_it_has_a_page(tmp_path, case):
    columns, rows = CASES[case]
    made = page_of(results_in(make(tmp_path / "sweep", columns, rows)), Options(pictures=0))
    said = {fact.name: fact for fact in made.facts}
    assert said["Trials"].value == str(len(rows)).replace("2500", "2\N{NARROW NO-BREAK SPACE}500")
    found = sum(one["status"] == "ok" for one in rows)
    assert said["Detection rate"].value == f"{100 * found / len(rows):.0f} %"
    made.all_figures()


@pytest.mark.slow
def test_the_browser_shows_all_of_them(tmp_path, opened):
    for number, (columns, rows) in enumerate(CASES.values()):
        folder = make(tmp_path / f"sweep{number}", columns, rows)
        with opened(written(folder), width=400) as shown:
            assert shown.locator(".said.wrong").count() == 0
            assert shown.evaluate("document.documentElement.scrollWidth") <= 400


def test_a_rate_is_100_percent_only_if_nothing_is_missed(tmp_path):
    rows = [row(k, 0.1 if k else None) for k in range(3000)]
    made = page_of(results_in(make(tmp_path / "sweep", [], rows)), Options(pictures=0))
    fact = next(fact for fact in made.facts if fact.name == "Detection rate")
    assert (fact.value, fact.remark) == ("99.9 %", "1 without a tip")


def test_numbers_are_those_of_plain_numpy(tmp_path):
    import numpy as np

    errors = np.random.default_rng(1).gamma(2.0, 0.01, 101)
    rows = [row(k, float(error)) for k, error in enumerate(errors)]
    made = page_of(results_in(make(tmp_path / "sweep", [], rows)), Options(pictures=0))
    said = {fact.name: fact.value for fact in made.facts}
    for name, value in (
        ("Median error", np.median(errors)),
        ("95 % of errors below", np.percentile(errors, 95)),
        ("Largest error", errors.max()),
    ):
        number, unit = said[name].split()
        assert unit == "\N{MICRO SIGN}m"
        assert float(number) == pytest.approx(1e3 * value, rel=5e-3)
