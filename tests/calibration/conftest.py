from __future__ import annotations

import json
import re
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import asked
import pytest
from asked import Answer
from oracles.stereo_boards import TARGET, photograph


def call(*arguments: object) -> Answer:
    """Call `simtip calibrate` in this process."""
    answer = asked.call("calibrate", *map(str, arguments))
    # on a slow machine progress is told, too
    told = [
        line
        for line in answer.err.splitlines(keepends=True)
        if not re.fullmatch(r"finding the target \d+%\n", line)
    ]
    return replace(answer, err="".join(told))


@pytest.fixture(scope="session")
def boards(tmp_path_factory) -> Path:
    """A folder of eight pairs of photographs of a chessboard, with truth.json."""
    folder = tmp_path_factory.mktemp("boards")
    photograph(folder)
    return folder


@dataclass(frozen=True)
class Calibrated:
    """What one call gave."""

    boards: Path
    folder: Path
    printed: dict


@pytest.fixture(scope="session")
def calibrated(boards, tmp_path_factory) -> Calibrated:
    """One call with all that it can write."""
    folder = tmp_path_factory.mktemp("calibrated")
    options = ("--target", TARGET, "--truth", boards / "truth.json", "--json")
    answer = call(boards, *options, "-o", folder / "rig.yaml", "--plots", folder / "plots")
    assert (answer.code, answer.err) == (0, "")
    return Calibrated(boards, folder, json.loads(answer.out))


@pytest.fixture
def ask():
    """Call `simtip calibrate`."""
    return call


@pytest.fixture
def some(boards, tmp_path):
    """Copy some of the views into a folder of their own."""

    def copy(*numbers: int) -> Path:
        folder = tmp_path / "some"
        folder.mkdir(exist_ok=True)
        for k in numbers:
            for side in ("left", "right"):
                shutil.copy(boards / f"{side}_{k:02d}.png", folder)
        return folder

    return copy


@pytest.fixture
def complaint():
    """Give the one line that an error is, without simtip's name."""

    def read(answer: Answer) -> str:
        assert answer.code == 2, answer
        assert answer.out == ""
        assert answer.err.count("\n") == 1, answer.err
        assert answer.err.startswith("simtip: ")
        return answer.err.removeprefix("simtip: ").rstrip("\n")

    return read
