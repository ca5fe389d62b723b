"""`simtip detectors check`: a line a case, exit code 0 kept, 1 broken, 2 a wrong call."""

from __future__ import annotations

import json

import pytest
from asked import call

from simtip.detect.contract import CASES

GOOD = """
from simtip.detect import lin2020
def good(image, *, threshold: int = 105):
    print("chatter")
    return lin2020.DETECTOR(image, threshold=threshold)
def bad(image):
    raise ValueError("it fell over")
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "checked_detectors.py").write_text(GOOD)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_a_function_that_keeps_it(capfd):
    answer = call("detectors", "check", "checked_detectors:good", "--json")
    found = json.loads(answer.out)
    assert (answer.code, found["ok"]) == (0, True)
    assert [case["name"] for case in found["cases"]] == [case.name for case in CASES]
    assert {case["outcome"] for case in found["cases"] if case["required"]} == {"passed"}
    captured = capfd.readouterr()
    assert captured.out == ""
    assert "chatter" in captured.err


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_settings_reach_the_detector_and_a_broken_contract_is_exit_code_1():
    answer = call("detectors", "check", "checked_detectors:good", "--set", "threshold=1")
    lines = answer.out.splitlines()
    assert answer.code == 1
    assert len(lines) == len(CASES) + 1
    assert lines[0].startswith("FAILED")
    assert lines[-1].startswith("checked_detectors:good fails ")


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_an_exception_is_told_case_by_case():
    answer = call("detectors", "--json", "check", "checked_detectors:bad")
    found = json.loads(answer.out)
    assert (answer.code, found["ok"]) == (1, False)
    assert (
        "detector_error on 300 x 360 px of 8 bits: ValueError: it fell over"
        in (found["cases"][0]["seen"])
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["lin2002"], "--detector: there is no detector 'lin2002'; did you mean 'lin2020'?"),
        (["lin2020", "--set", "threshold=x"], "--set threshold"),
        (["checked_detectors:none"], "has no 'none'"),
        ([], "Missing argument"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_a_wrong_call_is_one_line(arguments, said):
    answer = call("detectors", "check", *arguments)
    assert (answer.code, answer.out) == (2, "")
    assert said in answer.err
    assert answer.err.count("\n") == 1
