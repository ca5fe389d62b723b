"""Does a check say that the suite's file is another than when the baseline was recorded?"""

from __future__ import annotations

import pytest
import yaml
from made_up_baselines import baseline
from small_suites import checked, run, suite_file, texts

from simtip.regress.causes import NEW, NO_CASE, NO_CONDITION, remedy_of
from simtip.regress.junit import junit_of
from simtip.regress.markdown import markdown_of
from simtip.regress.recorded import suite_reference
from simtip.regress.suite import read_suite
from simtip.regress.suite_change import notes_of


def notes(path, said: dict) -> list[str]:
    """Give what is noted of a suite that was recorded first, and then edited so."""
    recorded = baseline().model_copy(update={"suite": suite_reference(read_suite(path), path)})
    path.write_text(yaml.safe_dump({**yaml.safe_load(path.read_text()), **said}))
    return notes_of(recorded, read_suite(path))


def test_the_same_suite_needs_no_note(tmp_path):
    path = suite_file(tmp_path)
    assert notes(path, {}) == []


def test_comments_and_layout_need_none(tmp_path):
    path = suite_file(tmp_path)
    reference = suite_reference(read_suite(path), path)
    path.write_text("# of last year\n" + yaml.safe_dump(yaml.safe_load(path.read_text()), indent=6))
    assert notes_of(baseline().model_copy(update={"suite": reference}), read_suite(path)) == []


def test_every_edited_tolerance_is_named_with_both_values(tmp_path):
    edited = {"tolerance": {"bias_px": 0.5, "time": 2.0}}
    said = notes(suite_file(tmp_path), edited)
    assert [one.split(":")[0] for one in said] == [
        "the suite's tolerance.bias_px is 0.5, was 0.02",
        "the suite's tolerance.time is 2, was 1.5",
    ]
    assert all("simtip regress update" in one for one in said)


@pytest.mark.parametrize(
    "edited",
    [
        {"about": "other words"},
        {"cases": [{"name": "nominal", "base": {"detect.threshold": 60}}]},
    ],
)
def test_whatever_else_was_edited_is_told(tmp_path, edited):
    (said,) = notes(suite_file(tmp_path), edited)
    assert said.startswith("the suite's file is another than when the baseline was recorded")


def test_other_noise_is_no_remedy_for_another_scene():
    """`--seed` compares what shows the same scene alone."""
    for cause in (NEW, NO_CASE, NO_CONDITION, "the scene was edited"):
        assert "--seed" not in remedy_of(cause)
        assert "update" in remedy_of(cause)
    assert "--all" in remedy_of(NO_CASE)
    assert "--seed" in remedy_of("the noise's seed is 2, was 1")


@pytest.mark.slow
def test_all_that_a_check_writes_has_the_note(tmp_path):
    cache, base = tmp_path / "cache", tmp_path / "base.yaml"
    path = suite_file(tmp_path, cases=[{"name": "nominal"}, {"name": "again"}])
    run("record", path, "-o", base, cache=cache)
    whole = {**yaml.safe_load(path.read_text()), "tolerance": {"rate": 0.5}}
    whole["cases"][1]["base"] = {"needle.roll_deg": 3.0}
    path.write_text(yaml.safe_dump(whole))
    result = checked(base, cache=cache, code=2)
    (note,) = result["notes"]
    assert note.startswith("the suite's tolerance.rate is 0.5, was 0.01")
    (said,) = texts(result, "could not tell")
    assert said == (
        "again cannot be compared: the scene was edited; `simtip regress update` accepts them"
    )
    assert note in junit_of(result).decode()
    assert "- note: the suite's tolerance.rate is 0.5" in markdown_of(result)
    shown, _ = run("check", base, "-o", tmp_path / "out", cache=cache, code=2)
    assert f"note: {note}\n" in shown
    # Once it is taken over, there is nothing to note.
    run("update", base, "--all", "--reason", "other limits", cache=cache)
    assert checked(base, cache=cache, code=0)["notes"] == []
