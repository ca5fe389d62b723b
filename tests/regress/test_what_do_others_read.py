"""Can JUnit's and GitHub's readers read what is written, whatever names and texts hold?"""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

import pytest
from junit_structure import strange

from simtip.regress.junit import junit_of
from simtip.regress.markdown import markdown_of

NASTY = 'a|b <script>`x` & "q" \u0007]]> *[l](u)* \x1b[2J'


def result(name: str = "nominal", text: str = "tip moved") -> dict:
    test = {"kind": "shift", "view": "left", "axis": "along", "before": 1.0, "after": 2.0}
    test |= {"change": 1.0, "tolerance": 0.1, "p": 1e-9, "least_p": 0, "state": "worse"}
    side = {"found": "1" * 12}
    condition = {"name": name, "case": name, "condition": "as it is", "state": "worse"}
    condition |= {"cause": None, "before": side, "after": side, "tests": [test], "power": None}
    quiet = {**condition, "name": "a quiet one", "state": "same", "tests": []}
    untold = {**condition, "name": "other", "state": "could not tell", "cause": "edited"}
    return {
        "verdict": "worse",
        "suite": name,
        "comparison": "same images",
        "detector": {"after": {"name": name, "parameters": {}}},
        "conditions": [quiet, condition, untold],
        "changes": [
            {"state": "worse", "kind": "shift", "where": [name], "text": text},
            {"state": "worse", "kind": "time", "where": [], "text": "slower: 2.0 x the time"},
        ],
        "notes": [text, text],
        "pooled": {"tests": []},
        "statistics": {"false_alarm_rate": 0.006, "tests_of_conditions": 9},
    }


@pytest.mark.parametrize("text", ["plain", NASTY])
def test_junit_counts_its_cases_and_says_what_is_wrong(text):
    root = ET.fromstring(junit_of(result(text, text)))  # noqa: S314 (written a moment ago)
    suite = root.find("testsuite")
    assert root.tag == "testsuites"
    cases = suite.findall("testcase")
    for one in (root, suite):
        assert int(one.get("tests")) == len(cases) == 3 + 5
        assert int(one.get("failures")) == len(suite.findall("testcase/failure")) == 2
        assert int(one.get("errors")) == len(suite.findall("testcase/error")) == 1
    assert strange(root) == []
    assert suite.get("skipped") == "0"
    assert suite.findtext("system-out").count("\n") == 1
    assert all({"name", "classname", "time"} <= set(case.attrib) for case in cases)
    assert all({"message", "type"} <= set(one.attrib) for one in suite.iter("failure"))
    assert len({(case.get("classname"), case.get("name")) for case in cases}) == len(cases)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (b"testcase", b"test", ["testsuite holds test", "no element test"] * 8),
        (b'<testsuite name="nominal" ', b"<testsuite ", ["testsuite lacks name"]),
        (b'errors="1" skipped', b"skipped", ["testsuite lacks errors"]),
        (b' time="0"', b' seconds="0"', ["testcase has seconds"] * 8),
        (b"<system-out>", b"<system-out><b/>", ["system-out holds b", "no element b"]),
        (b'skipped="0"', b'skipped="none"', ["skipped is no count"]),
    ],
)
def test_what_the_schema_forbids_would_be_seen(old, new, said):
    written = junit_of(result())
    assert strange(ET.fromstring(written)) == []  # noqa: S314 (written a moment ago)
    spoilt = written.replace(old, new)
    found = strange(ET.fromstring(spoilt))  # noqa: S314 (likewise)
    assert sorted(found) == sorted(said)


def test_a_shift_that_no_condition_shows_alone_is_a_failure():
    told = result()
    told["conditions"] = [{**one, "state": "same", "cause": None} for one in told["conditions"]]
    told["pooled"]["tests"] = [{"kind": "shift", "state": "worse"}]
    told["changes"] = [
        {**told["changes"][0], "where": ["nominal", "quiet", "other"]},
        told["changes"][1],
    ]
    root = ET.fromstring(junit_of(told))  # noqa: S314 (written a moment ago)
    failed = [
        case.get("name") for case in root.iter("testcase") if case.find("failure") is not None
    ]
    assert failed == ["shift", "time"]
    assert root.find(".//failure").get("message") == "tip moved"


def test_the_table_has_the_worst_first():
    rows = [line for line in markdown_of(result()).splitlines() if line.startswith("| ")][1:]
    names = [row.split("|")[2].strip() for row in rows]
    assert names == ["nominal", "other", "a quiet one"]


def test_names_are_no_markup():
    said = markdown_of(result(NASTY, NASTY))
    rows = [line for line in said.splitlines() if line.startswith("| ")]
    assert len({len(re.findall(r"(?<!\\)\|", row)) for row in rows}) == 1
    assert "<script>" not in said
    assert "](u)" not in said.replace("\\]", "")
