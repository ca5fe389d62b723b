"""A check as JUnit XML: a test case a condition, and those of all together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree as ET

from simtip.detect.excerpt import printable
from simtip.regress.change import UNTOLD, WORSE

POOLED = "all conditions"


def junit_of(result: dict[str, Any]) -> bytes:
    """Write a check's result as JUnit XML.

    What is worse is a failure; what could not be told is an error, since a run that skips it would
    pass.

    Parameters
    ----------
    result
        See `simtip.regress.result.result_of`.
    """
    cases = list(_cases(result))
    failures = sum(state == WORSE for _, _, state, _ in cases)
    errors = sum(state == UNTOLD for _, _, state, _ in cases)
    counts = {"tests": str(len(cases)), "failures": str(failures), "errors": str(errors)}
    suites = ET.Element("testsuites", {"name": "simtip regress", **counts})
    suite = ET.SubElement(
        suites, "testsuite", {"name": _clean(result["suite"]), **counts, "skipped": "0"}
    )
    for group, name, state, texts in cases:
        case = ET.SubElement(
            suite, "testcase", {"classname": _clean(group), "name": _clean(name), "time": "0"}
        )
        if state in (WORSE, UNTOLD):
            tag = "failure" if state == WORSE else "error"
            said = [_clean(text) for text in texts] or [state]
            told = ET.SubElement(case, tag, {"message": said[0], "type": state})
            told.text = "\n".join(said)
    if result["notes"]:
        ET.SubElement(suite, "system-out").text = "\n".join(map(_clean, result["notes"]))
    ET.indent(suites)
    written: bytes = ET.tostring(suites, encoding="utf-8", xml_declaration=True)
    return written + b"\n"


def _cases(result: dict[str, Any]) -> Iterator[tuple[str, str, str, list[str]]]:
    """Give group, name, state and words of every test case."""
    root = f"simtip.regress.{result['suite']}"
    lines = result["changes"]
    for one in result["conditions"]:
        texts = [line["text"] for line in lines if one["name"] in line["where"]]
        yield f"{root}.{one['case']}", one["name"], one["state"], texts
    for kind in ("detection", "shift", "spread", "outliers", "time"):
        told = [line for line in lines if line["kind"] == kind]
        states = [one["state"] for one in result["pooled"]["tests"] if one["kind"] == kind]
        states += [line["state"] for line in told if not line["where"]]
        state = next((s for s in (WORSE, UNTOLD) if s in states), "same")
        mine = [line for line in told if line["state"] == state]
        # What most conditions have in common may be seen in none of them alone.
        whole = [line for line in mine if not line["where"]] or mine
        yield f"{root}.{POOLED}", kind, state, [line["text"] for line in whole]


def _clean(text: str) -> str:
    """Leave out what XML cannot hold."""
    return printable(text)
