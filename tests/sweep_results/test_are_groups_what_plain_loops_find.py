"""Are rows chosen and grouped as loops over them would do it?"""

from __future__ import annotations

import math
import operator

import numpy as np
import pandas as pd
import pytest
from sweep_tables import make, row

from simtip.errors import InputError
from simtip.sweep.conditions import OPERATORS, filtered
from simtip.sweep.frames import plain
from simtip.sweep.summary import STATISTICS, grouped

BY = {
    "detect.threshold": [40, 60, 2**62 + 1, None],
    "needle.tip.kind": ["cone", "Bevel", "", None],
    "match.strict": [True, False, None],
    "lamps[0].power": [0.1, -1.5, 1e300, None],
}
NUMBERS = ["error_norm_mm", "error_x_mm", "detect.threshold", "match.strict"]


def some_rows(count: int) -> list[dict[str, object]]:
    rng = np.random.default_rng(12)
    rows = []
    for k in range(count):
        status = rng.choice(["ok", "ok", "no_tip", "failed"])
        more = {name: values[rng.integers(len(values))] for name, values in BY.items()}
        if status == "ok":
            more |= {"error_norm_mm": rng.exponential(), "error_x_mm": rng.normal()}
        rows.append({**row(int(k)), **more, "status": str(status)})
    # A group that has no number at all, and one of a single number.
    rows.append({**row(count), "needle.tip.kind": "none", "status": "failed"})
    rows.append({**row(count + 1), "needle.tip.kind": "one", "error_norm_mm": 2.0})
    return rows


@pytest.fixture(scope="module")
def rows() -> list[dict[str, object]]:
    return some_rows(300)


@pytest.fixture(scope="module")
def frame(rows, tmp_path_factory) -> pd.DataFrame:
    return make(tmp_path_factory.mktemp("table"), rows).frame()


def percentile(values: list[float], share: float) -> float:
    """Between the two nearest, by how near they are."""
    values = sorted(values)
    place = share * (len(values) - 1)
    low = math.floor(place)
    high = min(low + 1, len(values) - 1)
    return values[low] + (place - low) * (values[high] - values[low])


def plain_figure(how: str, values: list[float]) -> float:
    n = len(values)
    if how == "count":
        return n
    if n == 0 or (how == "std" and n == 1):
        return math.nan
    mean = sum(values) / n
    return {
        "mean": mean,
        "std": math.sqrt(sum((x - mean) ** 2 for x in values) / max(n - 1, 1)),
        "rms": math.sqrt(sum(x * x for x in values) / n),
        "median": percentile(values, 0.5),
        "min": min(values),
        "max": max(values),
        "p05": percentile(values, 0.05),
        "p95": percentile(values, 0.95),
        "mean_abs": sum(abs(x) for x in values) / n,
    }[how]


def in_order(key: tuple) -> tuple:
    return tuple((value is None, 0 if value is None else value) for value in key)


@pytest.mark.parametrize(
    "by",
    [[], *([name] for name in BY), ["detect.threshold", "needle.tip.kind"], [*BY], ["status"]],
    ids="-".join,
)
def test_every_figure_is_that_of_a_plain_loop(rows, frame, by):
    stats = [f"{name}:{how}" for name in NUMBERS for how in (*STATISTICS, "count")]
    found = grouped(frame, by, ["detection_rate", "count", *stats, "needle.tip.kind:count"])
    groups: dict[tuple, list[dict]] = {}
    for one in rows:
        groups.setdefault(tuple(one.get(name) for name in by), []).append(one)
    assert list(found.columns)[: len(by) + 3] == [*by, "n", "detection_rate", "count"]
    assert len(found) == len(groups)
    told = {name: plain(found[name]) for name in found.columns}
    for k, key in enumerate(sorted(groups, key=in_order)):
        group = groups[key]
        assert tuple(told[name][k] for name in by) == key
        assert told["n"][k] == told["count"][k] == len(group)
        rate = sum(one["status"] == "ok" for one in group) / len(group)
        assert told["detection_rate"][k] == pytest.approx(rate, abs=1e-15)
        kinds = sum(one.get("needle.tip.kind") is not None for one in group)
        assert told["needle.tip.kind:count"][k] == kinds
        for stat in stats:
            name, how = stat.split(":")
            values = [float(one[name]) for one in group if one.get(name) is not None]
            expected, figure = plain_figure(how, values), told[stat][k]
            figure = math.nan if figure is None else figure
            assert figure == pytest.approx(expected, rel=1e-12, nan_ok=True), (stat, key)


def test_groups_do_not_depend_on_the_order_of_rows(frame):
    turned = frame.iloc[::-1].set_index("trial", drop=False)
    stats = ["detection_rate", "error_norm_mm:median", "error_norm_mm:count"]
    expected = grouped(frame, [*BY], stats)
    pd.testing.assert_frame_equal(grouped(turned, [*BY], stats), expected)
    assert list(grouped(frame, ["status", "status"], stats * 2).columns) == ["status", "n", *stats]


def test_no_rows_make_no_groups_but_of_all(frame):
    none = frame.iloc[:0]
    stats = ["detection_rate", "count", "error_x_mm:mean", "error_x_mm:count"]
    found = grouped(none, ["detector"], stats)
    assert len(found) == 0
    assert list(found.columns) == ["detector", "n", *stats]
    (one,) = grouped(none, [], stats).to_dict("records")
    assert (one["n"], one["count"], one["error_x_mm:count"]) == (0, 0, 0)
    assert math.isnan(one["detection_rate"])
    assert math.isnan(one["error_x_mm:mean"])


def test_an_infinite_error_is_not_hidden(tmp_path):
    rows = [row(0, error_norm_mm=math.inf), row(1, error_norm_mm=1.0)]
    found = grouped(make(tmp_path, rows).frame(), [], ["error_norm_mm:mean", "error_norm_mm:std"])
    assert found["error_norm_mm:mean"][0] == math.inf
    assert math.isnan(found["error_norm_mm:std"][0])


VALUES = {
    "detect.threshold": [("60", 60), (str(2**62 + 1), 2**62 + 1), (str(2**62), 2**62), ("6e1", 60)],
    "trial": [("-1", -1), (str(10**30), 10**30), ("17", 17)],
    "lamps[0].power": [("0.1", 0.1), ("1e299", 1e299), ("-inf", -math.inf), (str(10**400), 1e999)],
    "needle.tip.kind": [("cone", "cone"), ("", ""), ("'cone'", "cone"), ("C", "C"), ("'", "'")],
}


@pytest.mark.parametrize("sign", OPERATORS)
@pytest.mark.parametrize(
    ("name", "text", "value"), [(n, t, v) for n, pairs in VALUES.items() for t, v in pairs]
)
def test_a_condition_keeps_what_a_plain_loop_keeps(rows, frame, name, sign, text, value):
    compare = getattr(
        operator,
        {"==": "eq", "!=": "ne", "<": "lt", "<=": "le", ">": "gt", ">=": "ge"}[sign],
    )
    kept = [r["key"] for r in rows if r.get(name) is not None and compare(r[name], value)]
    for condition in (f"{name}{sign}{text}", f" {name} {sign} {text} "):
        assert list(filtered(frame, [condition])["key"]) == kept


def test_truth_is_asked_by_its_name_and_missing_is_neither(rows, frame):
    for text, value in [("true", True), ("False", False)]:
        kept = [r["key"] for r in rows if r.get("match.strict") is value]
        assert kept
        assert list(filtered(frame, [f"match.strict=={text}"])["key"]) == kept
        other = "false" if value else "true"
        assert list(filtered(frame, [f"match.strict!={other}"])["key"]) == kept


def test_all_conditions_have_to_hold_and_none_keeps_all(rows, frame):
    found = filtered(frame, ["trial>=10", "trial<20", "status==ok"])
    assert list(found["trial"]) == [r["trial"] for r in rows[10:20] if r["status"] == "ok"]
    assert list(found.index) == list(range(len(found)))
    pd.testing.assert_frame_equal(filtered(frame, []), frame)


@pytest.mark.parametrize(
    ("condition", "problem"),
    [
        ("trial", "'trial' is not column OP value"),
        ("trial=3", "'trial=3' is not column OP value"),
        ("<3", "'<3' is not column OP value"),
        ("", "'' is not column OP value"),
        ("__import__('os').system('false')<1", "there is no column"),
        ("detect.treshold<60", "there is no column 'detect.treshold'; did you mean 'detect.thresh"),
        ("power<60", r"there is no column 'power'; did you mean 'lamps\[0\].power'"),
        ("zzzzzz<60", "there is no column 'zzzzzz'; known: key, trial"),
        ("trial<x", "'x' is no whole number, as trial is"),
        ("trial<1.5", "'1.5' is no whole number, as trial is"),
        ("trial<nan", "'nan' is no whole number"),
        ("trial<inf", "'inf' is no whole number"),
        ("error_norm_mm<", "'' is no number, as error_norm_mm is"),
        ("error_norm_mm!=nan", "'nan' is no number"),
        ("match.strict==1", "match.strict is true or false"),
        ("match.strict<true", "match.strict is true or false"),
    ],
)
def test_a_condition_that_means_nothing_is_one_line(frame, condition, problem):
    with pytest.raises(InputError, match=f"^--where: {problem}"):
        filtered(frame, [condition])


@pytest.mark.parametrize(
    ("by", "stats", "problem"),
    [
        (["detectr"], [], "--by: there is no column 'detectr'; did you mean 'detector'"),
        ([], ["detection_rat"], "--stat: 'detection_rat' is no stat.*mean 'detection_rate'"),
        ([], ["error_norm_mm"], "--stat: 'error_norm_mm' is no stat.*'error_norm_mm:mean'"),
        ([], ["error_norm:mean"], "--stat: there is no column 'error_norm'; did you mean"),
        ([], ["error_x_mm:meen"], "--stat: 'error_x_mm:meen' asks for an unknown.*mean 'mean'"),
        ([], ["status:mean"], "--stat: 'status:mean' needs numbers"),
        ([], [""], "--stat: '' is no statistic"),
    ],
)
def test_a_group_or_statistic_that_is_unknown_is_one_line(frame, by, stats, problem):
    with pytest.raises(InputError, match=problem):
        grouped(frame, by, stats)
