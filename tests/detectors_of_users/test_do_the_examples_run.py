"""Do the examples, and the code of docs/your_detector.md, find a needle as they say?"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from simtip import detect
from simtip.detect.observation import TipStatus

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples" / "detectors"
PAGE = (ROOT / "docs" / "your_detector.md").read_text(encoding="utf-8")


def needle(dtype=np.uint8):
    image = np.full((120, 160), 200, dtype)
    image[:90, 54:67] = 40
    return image * (1 if dtype == np.uint8 else 256)


@pytest.fixture
def beside(monkeypatch):
    """Work in the folder of the examples, and forget their modules afterwards."""
    monkeypatch.chdir(EXAMPLES)
    monkeypatch.syspath_prepend(str(EXAMPLES / "plugin"))
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        del sys.modules[name]


@pytest.mark.usefixtures("beside")
def test_the_python_function():
    find = detect.configure("edges:lowest_dark", {"level": "0.5"})
    for image in (needle(), needle(np.uint16), np.dstack([needle()] * 3)):
        o = find(image)
        assert o.tip_px.tolist() == [60, 89]
        assert o.axis_px == pytest.approx([0, -1])
    assert find(np.full((4, 4), 255, np.uint8)).status == "not_found"
    assert find(np.zeros((1, 1), np.uint8)).ok


@pytest.mark.usefixtures("beside")
def test_the_function_of_the_plugin():
    text = (EXAMPLES / "plugin" / "pyproject.toml").read_text()
    name, module, function = re.search(r'^(\w+) = "(\w+):(\w+)"$', text, re.MULTILINE).groups()
    reference = f"{module}:{function}"
    assert name == function
    o = detect.configure(reference)(needle(), layers=True)
    assert o.tip_px.tolist() == [54, 89]
    assert set(o.layers) == {"gray"}
    assert not detect.configure(reference, {"contrast": 250})(needle()).ok


def test_the_function_in_the_docs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    block = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1]
    (tmp_path / "shown.py").write_text(block)
    find = detect.configure("shown:lowest_dark", {"level": "0.3"})
    sys.modules.pop("shown")
    assert find(needle()).tip_px.tolist() == [60, 89]


def test_the_docs_tell_every_status_of_users_detectors_and_no_other():
    table = PAGE[PAGE.index("## What can go wrong") :]
    told = set(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE))
    assert told == {
        status.value
        for status in TipStatus
        if status.value.startswith(("not_found", "detector_", "command_", "invalid_"))
    }
    assert len(told) == 5


COMPILER = next(filter(None, map(shutil.which, ("c++", "g++", "clang++"))), None)


@pytest.mark.slow
@pytest.mark.skipif(COMPILER is None, reason="no C++ compiler here")
def test_the_program_in_cpp(tmp_path, monkeypatch, ask):
    monkeypatch.chdir(tmp_path)
    source = EXAMPLES / "lowest_dark.cpp"
    strict = ("-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror")
    subprocess.run([COMPILER, *strict, str(source), "-o", "lowest_dark"], check=True)
    reference = "cmd:./lowest_dark {image} {level}"
    settings = ("--set", "image_format=pgm", "--set", "level=0.5")
    cv2.imwrite("gray.png", needle())
    cv2.imwrite("deep.png", needle(np.uint16))
    cv2.imwrite("colour.png", np.dstack([needle()] * 3))
    images = ("gray.png", "deep.png", "colour.png")
    answer = ask("detect", *images, "--detector", reference, *settings, "--json")
    assert (answer.code, answer.err) == (0, "")
    assert [item["tip_px"] for item in json.loads(answer.out)] == [[60, 89]] * 3
    png = detect.configure(reference, {"level": "0.5"})(needle())
    assert (png.status, "is no binary PGM" in png.reason) == ("command_failed", True)
    dark = detect.configure(reference, {"level": "0.01", "image_format": "pgm"})(needle())
    assert (dark.status, "below 2.55 DN" in dark.reason) == ("not_found", True)
