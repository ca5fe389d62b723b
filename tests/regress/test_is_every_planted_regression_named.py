"""Faults planted in a detector: is each found by the command line, and called by its name?"""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree as ET

import pytest
import yaml
from small_suites import CASES, checked, run, run_as_users_do, suite_file, texts

from simtip.regress.compared import LEVEL
from simtip.regress.power import least_pooled_loss
from simtip.sweep.table import Table

pytestmark = pytest.mark.slow

TIMINGS = ["render_s", "sensor_s", "detect_s", "detector", "key", "code"]


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def base(tmp_path_factory, cache):
    """A baseline of the paper's detector as a module, and where it is."""
    folder = tmp_path_factory.mktemp("suite")
    file = folder / "base.yaml"
    run(
        *("record", suite_file(folder), "-o", file),
        *("--detector", "planted_detectors:unchanged"),
        cache=cache,
    )
    return file


@pytest.fixture(scope="module")
def lin2020(base, cache):
    """A baseline of the scene's own detector on the same suite."""
    file = base.with_name("lin2020.yaml")
    run("record", base.with_name("suite.yaml"), "-o", file, cache=cache)
    return file


def with_detector(base, cache, name, code):
    return checked(base, "--detector", f"planted_detectors:{name}", cache=cache, code=code)


def test_an_unchanged_detector_is_the_same_to_the_bit(base, cache, tmp_path):
    named = ("--detector", "planted_detectors:unchanged")
    result = checked(base, "-o", tmp_path / "out", *named, cache=cache, code=0)
    assert result["verdict"] == "same or better"
    assert result["changes"] == []
    assert result["comparison"] == "same images"
    # What is said to be seen is said of fresh noise.
    assert result["pooled"]["power"]["loss"] == least_pooled_loss(48, LEVEL)
    for one in result["conditions"]:
        for part in ("found", "images", "left", "right"):
            assert one["before"][part] == one["after"][part]
    assert json.loads((tmp_path / "out" / "regress.json").read_text()) == result
    frame = Table.open(tmp_path / "out" / "sweeps" / "000").frame()
    assert len(frame) == 12
    checked(base, "-o", tmp_path / "out", *named, cache=cache, code=0)  # gone on with
    pd_again = Table.open(tmp_path / "out" / "sweeps" / "000").frame()
    assert frame.equals(pd_again)


def test_code_runs_only_if_it_is_named(base, cache):
    _, said = run("check", base, cache=cache, code=2)
    assert "--detector" in said
    assert said.strip().count("\n") == 0


def test_a_shift_of_half_a_pixel_is_named_as_such(base, cache):
    result = with_detector(base, cache, "moved", 1)
    (said,) = [one for one in texts(result, "worse") if one.startswith("tip moved")]
    assert "tip moved by (+0.50, +0.00) px in both views, in 4 of 4 conditions" in said


def test_dropped_detections_are_counted(base, cache):
    result = with_detector(base, cache, "very_forgetful", 1)
    said = next(one for one in texts(result, "worse") if one.startswith("detections lost"))
    lost = int(re.search(r"\((\d+) lost, 0 gained\)", said)[1])
    before = sum(one["before"]["found"].count("1") for one in result["conditions"])
    after = sum(one["after"]["found"].count("1") for one in result["conditions"])
    assert lost == before - after > 0


def test_one_image_in_twenty_dropped_is_seen(base, cache):
    result = with_detector(base, cache, "forgetful", 1)
    assert any(one.startswith("detections lost") for one in texts(result, "worse"))


def test_few_dropped_detections_are_never_called_none(base, cache):
    """A few of 96 tips are too few to be sure of."""
    result = with_detector(base, cache, "hardly_forgetful", 2)
    assert any(one.startswith("detections lost") for one in texts(result, "could not tell"))


def test_scatter_is_named_as_scatter(base, cache):
    result = with_detector(base, cache, "shaky", 1)
    worse = texts(result, "worse")
    assert any(one.startswith("spread of all conditions") for one in worse)
    assert not any(one.startswith("tip moved") for one in worse)


def test_stray_tips_are_named(base, cache):
    result = with_detector(base, cache, "straying", 1)
    assert any(
        one.startswith(("tips far off", "detections lost")) for one in texts(result, "worse")
    )


@pytest.fixture(scope="module")
def timed(tmp_path_factory, cache):
    """Give what checks a detector of another name against a baseline of one condition."""
    folder = tmp_path_factory.mktemp("timed")
    file = folder / "base.yaml"
    words = "record", suite_file(folder, cases=CASES[:1]), "-o", file
    run_as_users_do(*words, "--detector", "planted_detectors:unchanged", cache=cache)

    def check(name, code):
        words = "check", file, "--json", "--detector", f"planted_detectors:{name}"
        return json.loads(run_as_users_do(*words, cache=cache, code=code))

    return check


def test_the_time_of_an_unchanged_detector_is_the_same(timed):
    result = timed("unchanged", 0)
    assert result["changes"] == []
    assert result["time"]["ratio"] == pytest.approx(1, abs=0.3)


@pytest.mark.parametrize("name", ["twice", "sleepy"])
def test_twice_the_time_is_named(timed, name):
    result = timed(name, 1)
    assert any(one.startswith("slower") for one in texts(result, "worse"))
    assert result["time"]["ratio"] > 1.5
    assert result["counts"]["worse"] == 0


def test_a_detector_that_fails_always_has_lost_all(base, cache):
    result = with_detector(base, cache, "broken", 1)
    assert any(
        "48 lost" in one and one.endswith("most often left_detector_error")
        for one in texts(result, "worse")
    )
    assert texts(result, "better") == []  # nor is it faster
    assert result["time"] is None


def test_a_detector_that_fails_always_is_not_accepted(base, cache):
    before = base.read_bytes()
    _, error = run(
        *("update", base, "--all", "--reason", "why not"),
        *("--detector", "planted_detectors:broken"),
        cache=cache,
        code=2,
    )
    assert "no tip was found in any of 4 conditions" in error
    assert base.read_bytes() == before


def test_an_improvement_is_none_of_these(base, cache):
    result = with_detector(base, cache, "true_to_the_pixel", 0)
    assert result["verdict"] == "same or better"
    assert any("tip moved by (+0.00, +8.00) px" in one for one in texts(result, "better"))


@pytest.mark.parametrize(
    ("setting", "code"), [("threshold=95", 1), ("threshold=115", 0), ("median_window=1", 1)]
)
def test_other_parameters_move_the_tip(lin2020, cache, setting, code):
    """A higher threshold brings these tips nearer."""
    result = checked(lin2020, "--set", setting, cache=cache, code=code)
    assert any("tip moved" in line["text"] for line in result["changes"])


def test_fresh_noise_of_an_unchanged_detector_is_no_change(lin2020, cache):
    for seed in (2, 3):
        result = checked(lin2020, "--seed", seed, cache=cache, code=0)
        assert result["comparison"] == "fresh noise"
        hashes = [[one[k]["images"] for k in ("before", "after")] for one in result["conditions"]]
        assert all(before != after for before, after in hashes)


def test_fresh_noise_hides_no_shift(base, cache):
    options = ("--seed", 2, "--detector", "planted_detectors:moved")
    result = checked(base, *options, cache=cache, code=1)
    assert any("tip moved by (+0.50, +0.00) px" in one for one in texts(result, "worse"))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seed": 2}, "the noise's seed is 2, was 1"),
        ({"base": {"needle.roll_deg": 5.0}}, "the scene was edited"),
        ({"repeats": 6}, "there are 6 repeats, and were 12"),
        ({"factors": {"lamps[0].power": [1.0]}}, "the baseline does not have it"),
    ],
)
def test_other_images_are_told_with_their_cause(lin2020, cache, change, said):
    suite = lin2020.with_name("suite.yaml")
    whole = yaml.safe_load(suite.read_text())
    before = suite.read_text()
    whole["cases"][0] |= change
    suite.write_text(yaml.safe_dump(whole))
    try:
        result = checked(lin2020, cache=cache, code=2)
    finally:
        suite.write_text(before)
    assert any(said in one for one in texts(result, "could not tell"))
    assert result["counts"]["could not tell"] >= 1
    assert result["counts"]["same"] == 3


def test_a_suite_of_other_seeds_tells_nothing(lin2020, cache):
    suite = lin2020.with_name("suite.yaml")
    before = suite.read_text()
    whole = yaml.safe_load(before)
    whole["cases"] = [{**case, "seed": 2} for case in whole["cases"]]
    suite.write_text(yaml.safe_dump(whole))
    try:
        said, _ = run("check", lin2020, cache=cache, code=2)
    finally:
        suite.write_text(before)
    assert "all conditions cannot be compared: the noise's seed is 2, was 1" in said


def test_without_a_cache_the_images_are_the_same(lin2020, cache):
    result = checked(lin2020, "--cache-size", "0B", cache=cache, code=0)
    assert result["comparison"] == "same images"


def test_files_for_others_say_the_same(base, cache, tmp_path):
    junit, summary, added = (tmp_path / name for name in ("j.xml", "s.md", "added.md"))
    options = ("--detector", "planted_detectors:moved")
    result = checked(base, *options, "--junit", junit, "--summary", summary, cache=cache, code=1)
    root = ET.parse(junit).getroot()  # noqa: S314 (written a moment ago)
    assert int(root.get("failures")) == len(root.findall(".//failure")) > 0
    assert len(root.findall(".//testcase")) == int(root.get("tests"))
    assert result["changes"][0]["text"] in root.find(".//failure").get("message")
    assert "| condition |" in summary.read_text()
    assert "worse" in summary.read_text()
    added.write_text("before\n")
    run("check", base, *options, cache=cache, code=1, GITHUB_STEP_SUMMARY=str(added))
    assert added.read_text().startswith("before\n## ")


def test_an_accepted_change_is_the_new_baseline(lin2020, cache):
    file = lin2020.with_name("updated.yaml")
    file.write_bytes(lin2020.read_bytes())
    scene = lin2020.with_name("scene.yaml")
    before = scene.read_text()
    data = yaml.safe_load(before)
    data["detect"]["threshold"] = 95
    scene.write_text(yaml.safe_dump(data))
    try:
        assert checked(file, cache=cache, code=1)["counts"]["worse"] == 2
        run("update", file, "--case", "lamps", "--reason", "a new threshold", cache=cache)
        result = checked(file, cache=cache, code=0)
        assert [one["case"] for one in result["accepted"]] == ["lamps"]
        assert result["accepted"][0]["reason"] == "a new threshold"
        assert any("shift" in one for one in result["accepted"][0]["changes"])
        run("update", file, "--all", "--reason", "all of it", cache=cache)
        assert len(checked(file, cache=cache, code=0)["accepted"]) == 4
    finally:
        scene.write_text(before)
    unchanged = yaml.safe_load(lin2020.read_text())["cases"][0]
    assert yaml.safe_load(file.read_text())["cases"][0] == unchanged


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--all", "--reason", "  "], "--reason"),
        (["--reason", "x"], "--case"),
        (["--case", "nominal", "--all", "--reason", "x"], "--all"),
        (["--case", "nominl", "--reason", "x"], "did you mean 'nominal'?"),
        (["--case", "nominal", "--set", "threshold=90", "--reason", "x"], "--all"),
    ],
)
def test_what_cannot_be_accepted_changes_nothing(lin2020, cache, words, said):
    before = lin2020.read_bytes()
    _, told = run("update", lin2020, *words, cache=cache, code=2)
    assert said in told
    assert lin2020.read_bytes() == before


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--set", "treshold=90"], "threshold"),
        (["--set", "threshold"], "KEY=VALUE"),
        (["--detector", "nothing"], "--detector"),
        (["--detector", "planted_detectors:none"], "--detector"),
        (["--junit", "none/j.xml"], "none/j.xml"),
        (["-o", "{folder}"], "holds something else"),
    ],
)
def test_what_cannot_be_checked_is_one_line(lin2020, cache, words, said):
    told = [word.format(folder=lin2020.parent) for word in words]
    _, error = run("check", lin2020, *told, cache=cache, code=2)
    assert said in error
    assert error.count("\n") == 1


def test_a_folder_cut_short_is_told_or_mended(lin2020, cache, tmp_path):
    out = tmp_path / "out"
    checked(lin2020, "-o", out, cache=cache, code=0)
    part = next((out / "sweeps" / "000").glob("rows*/*.parquet"))
    part.write_bytes(part.read_bytes()[:100])
    _, error = run("check", lin2020, "-o", out, cache=cache, code=2)
    assert str(part) in error
    assert error.strip().splitlines()[-1].startswith("simtip: ")


def test_nothing_found_is_no_baseline(cache, tmp_path):
    _, error = run(
        *("record", suite_file(tmp_path), "-o", tmp_path / "b.yaml"),
        *("--detector", "planted_detectors:broken"),
        cache=cache,
        code=2,
    )
    assert "no tip was found" in error
    assert not (tmp_path / "b.yaml").exists()


def test_a_program_that_hangs_ends_at_the_time_limit_and_is_named(tmp_path, cache):
    suite = suite_file(tmp_path, repeats=2, cases=[{"name": "nominal"}])
    run("record", suite, "-o", tmp_path / "base.yaml", cache=cache)
    program = tmp_path / "hanging"
    program.write_text("#!/bin/sh\nexec sleep 1000\n")
    program.chmod(0o755)
    said = run_as_users_do(
        *("check", tmp_path / "base.yaml", "--json", "--workers", "1", "--time-limit", "2"),
        *("--detector", f"cmd:{program} {{image}}"),
        cache=cache,
        code=2,
    )
    (line,) = [one for one in texts(json.loads(said), "could not tell") if "nominal" in one]
    assert "2 of 2 before, 0 of 2 now: left_command_timed_out" in line
