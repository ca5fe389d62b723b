"""A user's tests of a detector, in a folder of their own, on a scene that renders in no time."""

from __future__ import annotations

import importlib.metadata
import sys
from pathlib import Path

import pytest
import yaml

SCENES = Path(__file__).resolve().parents[2] / "scenes"

INSTALLED = any(
    entry.name == "simtip" for entry in importlib.metadata.entry_points(group="pytest11")
)
PLUGIN = () if INSTALLED else ("-p", "simtip.pytest_plugin")
"""pytest finds the plug-in by itself where this version of simtip is installed."""

DETECTOR = """
def lowest_dark(image, *, level: float = 0.45):
    rows, columns = (image.mean(axis=2) < level * 255).nonzero()
    return None if rows.size == 0 else (columns[rows == rows.max()].mean(), rows.max())
"""


def tiny_scene() -> dict:
    """Give the paper's set-up, read out in two small regions around the tip."""
    data = yaml.safe_load((SCENES / "01_single_tip.yaml").read_text(encoding="utf-8"))
    data["name"] = "tiny"
    data["rig"]["left"]["roi"] = [770, 760, 100, 150]
    data["rig"]["right"]["roi"] = [983, 755, 100, 150]
    data["render"] = {"noise": None, "samples": 4, "light_step_mm": 4.0}
    data["detect"] = {"name": "lin2020", "min_area_px": 300}
    return data


SUITE = {
    "name": "mine",
    "scene": "tiny.yaml",
    "repeats": 3,
    "cases": [
        {"name": "nominal"},
        {"name": "two lamps' powers", "factors": {"lamps[0].power": [1.0, 1.5]}},
        {"name": "away", "base": {"rig.right.roi": [983, 655, 100, 150]}},
        {"name": "thresholds", "factors": {"detect.threshold": [80, 90, 100, 110]}},
    ],
}


class UsersTests:
    """A folder with a scene, a suite and a detector, in which a user writes tests and runs them."""

    def __init__(
        self, pytester: pytest.Pytester, cache: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        self.pytester, self.path, self._cache = pytester, pytester.path, cache
        self._monkeypatch = monkeypatch
        self.write("tiny.yaml", yaml.safe_dump(tiny_scene()))
        self.write("suite.yaml", yaml.safe_dump(SUITE))
        self.write("detectors.py", DETECTOR)

    def write(self, name: str, text: str) -> Path:
        """Write a file."""
        path = self.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def test(self, body: str, name: str = "test_mine.py") -> Path:
        """Write a file of tests, in which the detector is at hand."""
        return self.write(name, f"import pytest\nfrom detectors import lowest_dark\n\n{body}\n")

    def run(self, *options: object, others: bool = False) -> pytest.RunResult:
        """Run the tests in this process, which may have loaded modules of the same names.

        Other plug-ins that are installed are left out unless they are the question: some load
        much, which is forgotten after each run.
        """
        for path in self.path.rglob("*.py"):
            self._monkeypatch.delitem(sys.modules, path.stem, raising=False)
        if not others:
            self._monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
        own = PLUGIN if others else ("-p", "simtip.pytest_plugin")
        words = map(str, (*own, f"--simtip-cache={self._cache}", *options))
        return self.pytester.runpytest_inprocess("-p", "no:cacheprovider", *words)

    def in_a_process(self, *options: object) -> pytest.RunResult:
        """Run them as users do."""
        words = map(str, (*PLUGIN, f"--simtip-cache={self._cache}", *options))
        return self.pytester.runpytest_subprocess(*words)

    def pictures(self, folder: str = ".simtip-failures") -> list[str]:
        """List the pictures of failures."""
        base = self.path / folder
        return sorted(path.relative_to(base).as_posix() for path in base.rglob("*.png"))
