"""The tests and commands of docs/pytest.md, copied out as a user would."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
import yaml

from simtip.pytest_plugin.case import PairsOfCase
from simtip.pytest_plugin.options import USUAL_ARTIFACTS
from simtip.pytest_plugin.pair import MeasuredPair, Pair
from simtip.pytest_plugin.used import MOST_PICTURES

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "pytest.md").read_text(encoding="utf-8")
TEST, SUITE = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
SHOWN = re.search(r"^```text\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)[1]


@pytest.fixture
def copied(mine):
    """A folder with the scene that comes with simtip, and the page's test."""
    shutil.copy(ROOT / "simtip" / "regress" / "standard" / "bench.yaml", mine.path)
    (mine.path / "detectors.py").unlink()
    mine.write("test_my_detector.py", TEST)
    return mine


def test_it_has_ten_lines():
    code = [line for line in TEST.splitlines() if line and not line.startswith("#")]
    assert len(code) <= 10


@pytest.mark.slow
def test_the_first_one_runs_and_fails_as_shown(copied):
    copied.run("test_my_detector.py").assert_outcomes(passed=1)
    assert copied.pictures() == []
    copied.write("test_my_detector.py", TEST.replace("px=8, mm=1", "px=1"))
    done = copied.run("test_my_detector.py")
    done.assert_outcomes(failed=1)
    for line in SHOWN.splitlines():
        if not line.startswith("---"):  # as wide as the terminal
            assert line in done.outlines, line
    assert len(copied.pictures()) == 1


@pytest.mark.slow
def test_the_one_of_suites_runs(copied):
    """On a suite with cases of the names shown, of a scene that renders in no time."""
    cases = [
        {"name": "nominal"},
        {"name": "noisy", "base": {"sensor.read_noise_e": 20.0}},
        {"name": "no tip in view", "base": {"rig.right.roi": [983, 555, 100, 150]}},
    ]
    suite = {"name": "m", "scene": "tiny.yaml", "repeats": 4, "cases": cases}
    copied.write("my_suite.yaml", yaml.safe_dump(suite))
    copied.write("test_suites.py", SUITE)
    done = copied.run("test_suites.py", "--simtip-suite=my_suite.yaml", "-v")
    said = done.stdout.str()
    for name in (
        "test_every_case[nominal] PASSED",
        "test_every_case[noisy] PASSED",
        "test_every_case[no tip in view] FAILED",  # as the page says
        "test_is_unbiased_across[nominal] PASSED",
    ):
        assert f"test_suites.py::{name}" in said
    done.assert_outcomes(passed=3, failed=1)


def test_every_option_and_attribute_is_told_and_is_there(mine):
    options = set(re.findall(r"--simtip-\w+=", mine.run("--help").stdout.str()))
    assert options == set(re.findall(r"^\| `(--simtip-\w+=)", PAGE, re.MULTILINE))
    assert len(options) == 5
    table = PAGE[PAGE.index("The pair has") : PAGE.index("A detector is a function")]
    told = re.findall(
        r"`(\w+)(?:\(.*?\))?`", "".join(re.findall(r"^\| (`.*?) \|", table, re.MULTILINE))
    )
    assert len(told) == 9
    fields = {"scene"}
    assert all(hasattr(Pair, name) or name in fields for name in told)
    assert f"`{USUAL_ARTIFACTS}`" in PAGE
    assert {"first\neight", "last eight"} <= set(re.findall(r"(?:first|last)\s+eight", PAGE))
    assert MOST_PICTURES == 8
    assert hasattr(PairsOfCase, "assert_tips_within")
    assert hasattr(MeasuredPair, "assert_within")
