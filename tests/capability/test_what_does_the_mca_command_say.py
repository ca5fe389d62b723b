"""Does `simtip mca --csv` give what the columns allow, and say what it leaves out?"""

from __future__ import annotations

import json

import numpy as np
import pytest
from asked import call
from capability.published import AIAG, MINI, WRIGHT, rv_ic

TARGETS = np.arange(2, 30, 2.0)


def needle(rng):
    """Five runs of 14 displacements, as the paper has them: vision against laser, mm."""
    rows = []
    for run in range(5):
        laser = TARGETS + rng.normal(0, 0.002, 14)
        vision = laser + 0.29 + rng.normal(0, 0.017, 14)
        rows += [(run, f"{k}", *pair) for k, pair in enumerate(zip(laser, vision, strict=True))]
    return rows


@pytest.fixture
def written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")

    def write(header, rows):
        lines = [header, *(",".join(map(str, row)) for row in rows)]
        (tmp_path / "m.csv").write_text("\n".join(lines))
        return "m.csv"

    return write


def asked(*arguments):
    told = call("mca", "--csv", *arguments, "--json")
    assert told.code == 0, told.err
    return json.loads(told.out)


def test_all_of_the_papers_procedure_from_one_file(written):
    rows = needle(np.random.default_rng(7))
    found = asked(written("run,part,reference,measured", rows), "--tolerance", "0.62")
    laser, vision = (np.array([row[k] for row in rows]) for k in (2, 3))
    error = vision - laser
    assert found["accuracy"]["mean_abs_mm"] == pytest.approx(np.abs(error).mean(), rel=1e-12)
    assert found["accuracy"]["max_abs_mm"] == pytest.approx(np.abs(error).max(), rel=1e-12)
    assert found["accuracy"]["rms_mm"] == pytest.approx(np.sqrt((error**2).mean()), rel=1e-12)
    r2 = np.corrcoef(laser, vision)[0, 1] ** 2
    assert found["accuracy"]["r2_cumulative"] == pytest.approx(r2, rel=1e-12)
    steps = [np.diff(v.reshape(5, 14), prepend=0).ravel() for v in (laser, vision)]
    assert found["accuracy"]["r2_step"] == pytest.approx(np.corrcoef(*steps)[0, 1] ** 2, rel=1e-9)
    assert found["agreement"]["sd_mm"] == pytest.approx(error.std(ddof=1), rel=1e-12)
    by_target = vision.reshape(5, 14)
    sigma = np.sqrt(by_target.var(axis=0, ddof=1).mean())
    assert found["repeatability"]["sigma_mm"] == pytest.approx(sigma, rel=1e-12)
    assert found["repeatability"]["p_t_percent"] == pytest.approx(600 * sigma / 0.62, rel=1e-12)
    only_error = np.sqrt(error.reshape(5, 14).var(axis=0, ddof=1).mean())
    of_errors = found["repeatability"]["of_errors"]["sigma_mm"]
    assert of_errors == pytest.approx(only_error, rel=1e-9)
    assert (found["runs"], found["rows"]) == (5, 70)
    assert found["grr"] is None
    assert found["left_out"] == {"grr": "there is no column operator"}
    assert any("each taken as independent" in note for note in found["agreement"]["notes"])


def test_every_key_that_is_promised_is_there(written):
    rows = [(p, o, t, p * p, p * p + y) for (p, o, t), y in np.ndenumerate(AIAG / 10)]
    found = asked(written("part,operator,trial,reference,measured", rows), "--tolerance", "1")
    promised = {
        "accuracy": ["mean_abs_mm", "max_abs_mm", "rms_mm", "r2_step", "r2_cumulative"],
        "agreement": ["bias_mm", "sd_mm", "loa_lower_mm", "loa_upper_mm", "loa_lower_ci_mm",
                      "loa_upper_ci_mm", "pearson_r", "ccc"],
        "repeatability": ["sigma_mm", "p_t_percent", "multiplier"],
        "grr": ["ev", "av", "grr", "pv", "tv", "interaction", "ndc", "grr_percent_tv"],
    }  # fmt: skip
    for name, keys in promised.items():
        for key in keys:
            assert found[name][key] is not None, f"{name}.{key}"
    assert found["left_out"] == {}
    assert found["runs"] == 9  # without a column, a trial by an operator
    # Repeatability is within a part and an operator: EV before the interaction is pooled.
    error = next(row for row in found["grr"]["anova"] if row["source"] == "repeatability")
    assert found["repeatability"]["sigma_mm"] ** 2 == pytest.approx(error["ms"], rel=1e-9)


def test_a_gauge_study_needs_three_columns_and_no_order(written):
    rows = [(f"part {p}", "ABC"[o], y) for (p, o, _), y in np.ndenumerate(AIAG)]
    np.random.default_rng(1).shuffle(rows)
    found = asked(written("part,operator,measured", rows))
    assert round(found["grr"]["grr"], 5) == 0.30237
    assert found["grr"]["ndc"] == 4
    assert found["grr"]["percent_tolerance"] is None
    assert found["accuracy"] is found["agreement"] is None
    assert found["left_out"]["accuracy"] == "there is no column reference"
    assert found["repeatability"]["p_t_percent"] is None


def test_the_files_own_headers_can_be_named(written):
    path = written("xl80,vision", zip(MINI, WRIGHT, strict=True))
    found = asked(path, "--column", "reference=xl80", "--column", "measured = vision")
    assert round(found["agreement"]["bias_mm"], 1) == -2.1
    assert found["columns"] == {"reference": "xl80", "measured": "vision"}


@pytest.mark.parametrize(("kind", "sd"), [("varies", 0.99062408), ("constant", 1.0518506)])
def test_repeated_pairs_are_analysed_as_such_if_asked(written, kind, sd):
    rv, ic, who = rv_ic()
    path = written("part,measured,reference", zip(who, rv, ic, strict=True))
    assert asked(path)["agreement"]["sd_mm"] == pytest.approx(0.9610571, abs=5e-8)
    found = asked(path, "--repeated", kind)["agreement"]
    assert found["sd_mm"] == pytest.approx(sd, abs=1e-7)
    assert "MOVER" in found["method"]
    assert any("correlations" in note for note in found["notes"])


def test_level_and_multiplier_do_what_they_say(written):
    path = written("run,part,reference,measured", needle(np.random.default_rng(7)))
    wide = asked(path, "--level", "0.99", "--tolerance", "1", "--multiplier", "5.15")
    usual = asked(path, "--tolerance", "1")
    for name in ("bias_ci_mm", "loa_upper_ci_mm", "pearson_r_ci", "ccc_ci"):
        low, high = usual["agreement"][name]
        assert wide["agreement"][name][0] < low < high < wide["agreement"][name][1], name
    assert wide["agreement"]["loa_upper_mm"] == usual["agreement"]["loa_upper_mm"]
    ratio = wide["repeatability"]["p_t_percent"] / usual["repeatability"]["p_t_percent"]
    assert ratio == pytest.approx(5.15 / 6)
    assert (wide["level"], wide["repeatability"]["multiplier"]) == (0.99, 5.15)


def test_positions_and_displacements_of_one_motion_tell_the_same(written):
    rng = np.random.default_rng(3)
    laser = np.cumsum(rng.uniform(1, 3, 12))
    vision = laser * 1.01 + rng.normal(0, 0.05, 12)
    rows = list(zip(laser + 55, vision - 7, strict=True))
    position = asked(written("reference,measured", rows), "--readings", "position")
    moved = zip(laser[1:] - laser[0], vision[1:] - vision[0], strict=True)
    displacement = asked(written("reference,measured", moved))
    steps = zip(np.diff(laser), np.diff(vision), strict=True)
    step = asked(written("reference,measured", steps), "--readings", "step")
    for name in ("r2_step", "r2_cumulative"):
        value = position["accuracy"][name]
        assert displacement["accuracy"][name] == pytest.approx(value, rel=1e-9), name
        assert step["accuracy"][name] == pytest.approx(value, rel=1e-9), name
    assert position["agreement"]["sd_mm"] == pytest.approx(displacement["agreement"]["sd_mm"])
    summary = step["accuracy"]["steps"]["rms_mm"]
    assert position["accuracy"]["steps"]["rms_mm"] == pytest.approx(summary)
    assert step["accuracy"]["rms_mm"] == summary


@pytest.mark.parametrize(
    ("header", "rows", "left_out"),
    [
        ("measured", [(1,), (2,), (4,)], {"grr": "column part", "repeatability": "column part"}),
        ("part,measured", [("a", 1), ("b", 2), ("c", 3)], {"repeatability": "measured twice"}),
        (
            "part,operator,measured",
            [(p, o, p + 0.1 * (o == "y")) for p in (1, 2) for o in "xy"],
            {"repeatability": "twice by one operator", "grr": "takes two trials"},
        ),
        (
            "part,operator,measured",
            [(p, "x", p + 0.1 * k) for p in (1, 2) for k in range(2)],
            {"grr": "one operator only"},
        ),
        (
            "part,operator,measured",
            [("a", o, k + 0.1 * (o == "y")) for o in "xy" for k in range(2)],
            {"grr": "one part only"},
        ),
    ],
)
def test_what_the_columns_do_not_allow_is_left_out_and_said(written, header, rows, left_out):
    path = written(header, rows)
    found = asked(path)
    people = call("mca", "--csv", path)
    for name, reason in left_out.items():
        assert found[name] is None
        assert reason in found["left_out"][name]
        assert f"{name} is left out: {found['left_out'][name]}" in people.out


def test_a_start_of_0_by_definition_is_pointed_out(written):
    rows = [(0, 0), (2, 2.25), (4, 4.5), (6, 6.125)]
    assert "1 of the rows are 0" in asked(written("reference,measured", rows))["notes"][0]
    assert not any("are 0" in n for n in asked(written("reference,measured", rows[1:]))["notes"])


def test_equal_steps_of_the_reference_have_no_r_squared_and_that_is_said(written):
    found = asked(written("reference,measured", [(2, 2.25), (4, 4.5), (6, 6.125), (8, 8.25)]))
    assert found["accuracy"]["r2_step"] is None
    assert found["notes"] == [
        "there is no r2_step: the steps of one column do not vary, or are fewer than 3"
    ]


def test_people_see_the_same_figures(written):
    rows = [
        (p, "ABC"[o], t, p * p + 1, p * p + 1 + y / 10) for (p, o, t), y in np.ndenumerate(AIAG)
    ]
    path = written("part,operator,trial,reference,measured", rows)
    told, found = call("mca", "--csv", path, "--tolerance", "2"), asked(path, "--tolerance", "2")
    assert (told.code, told.err) == (0, "")
    for value in (
        found["accuracy"]["rms_mm"],
        found["accuracy"]["r2_step"],
        found["agreement"]["loa_lower_mm"],
        found["agreement"]["loa_upper_ci_mm"][1],
        found["agreement"]["ccc"],
        found["repeatability"]["p_t_percent"],
        found["grr"]["av"],
        found["grr"]["average_and_range"]["pv"],
    ):
        assert f"{value:.6g}" in told.out
    low, high = found["repeatability"]["p_t_ci_percent"]
    assert f"{low:.6g} .. {high:.6g}" in told.out
    assert "pooled with repeatability" in told.out
    assert "P/T is" in told.out
    assert f"ndc {found['grr']['ndc']};" in told.out


def test_help_names_the_columns():
    told = call("mca", "--help")
    assert told.code == 0
    words = " ".join(told.out.replace("│", " ").split())
    for name in ("measured", "reference", "part", "operator", "trial", "run"):
        assert name in words
