from __future__ import annotations

import json
import re
import subprocess
import sys

import pytest

HEAVY = (
    "numpy",
    "scipy",
    "pydantic",
    "mitsuba",
    "drjit",
    "cv2",
    "yaml",
    "pandas",
    "simtip.sweep",
    "simtip.spec",
)


TELL = """
import json, pathlib, sys

def pytest_sessionfinish():
    pathlib.Path("loaded.json").write_text(json.dumps(sorted(sys.modules)))
"""


def loaded(mine) -> set[str]:
    """Run the tests, and give the modules that were loaded at their end."""
    mine.write("conftest.py", TELL)
    mine.in_a_process("-W", "error").assert_outcomes(passed=1)
    return set(json.loads((mine.path / "loaded.json").read_text()))


def test_a_test_that_needs_no_pair_loads_next_to_nothing(mine):
    mine.write("test_mine.py", "def test(): ...\n")
    modules = loaded(mine)
    assert {name for name in modules if name.startswith("simtip")} == {
        "simtip",
        "simtip.version",
        "simtip.pytest_plugin",
        "simtip.pytest_plugin.options",
        "simtip.pytest_plugin.stashed",
    }
    assert not [name for name in modules if name.startswith(HEAVY)]


@pytest.mark.slow
def test_what_a_test_uses_would_be_seen(mine):
    mine.test("def test(simtip_pair): ...")
    assert {"numpy", "simtip.sweep.stages"} <= loaded(mine)


def test_it_is_loaded_in_no_time():
    """In some 3 ms on a quiet machine."""
    timed = (
        "import time, pytest\n"
        "start = time.perf_counter()\n"
        "import simtip.pytest_plugin\n"
        "print(time.perf_counter() - start)"
    )
    took_s = (
        float(subprocess.check_output([sys.executable, "-c", timed], text=True)) for _ in range(3)
    )
    assert any(one_s < 0.05 for one_s in took_s)


@pytest.mark.slow
def test_it_can_be_switched_off(mine):
    mine.write("test_mine.py", "def test(simtip_pair): ...\n")
    done = mine.pytester.runpytest_subprocess("-p", "no:simtip", "-p", "no:simtip.pytest_plugin")
    done.assert_outcomes(errors=1)
    done.stdout.fnmatch_lines(["*fixture 'simtip_pair' not found"])
    helped = mine.pytester.runpytest_subprocess("-p", "no:simtip", "--help")
    assert "--simtip-suite" not in helped.stdout.str()


def test_help_markers_and_fixtures_tell_of_it(mine):
    assert "--simtip-suite=SUITE" in mine.run("--help").stdout.str()
    mine.run("--markers").stdout.fnmatch_lines(
        ["@pytest.mark.simtip(suite=..., cases=[[]...[]], repeats=N): *"]
    )
    said = mine.run("--fixtures").stdout.str()
    for name in ("simtip_pair", "simtip_suite"):
        assert re.search(rf"^{name} -- .*\n    \S+", said, re.MULTILINE), name


def test_its_marker_is_known(mine):
    mine.test("@pytest.mark.simtip(repeats=2)\ndef test(): ...")
    mine.run("--strict-markers").assert_outcomes(passed=1)


@pytest.mark.slow
def test_it_is_silent_about_warnings(mine):
    mine.test("def test(simtip_pair):\n    simtip_pair('tiny.yaml')")
    done = mine.in_a_process("-W", "error")
    done.assert_outcomes(passed=1, warnings=0)
