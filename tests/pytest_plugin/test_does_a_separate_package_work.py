"""A package of its own, in a new environment, with simtip installed from its wheel."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import numpy as np
import pytest

from simtip.image_file import read_image

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "pytest.md").read_text(encoding="utf-8")

PROJECT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "my-tips"
version = "1.0"

[tool.pytest.ini_options]
addopts = "--strict-markers -W error"
"""

DETECTOR = '''
"""A package with a detector."""


def find_tip(image):
    """Take the lowest dark pixel for the tip."""
    rows, columns = (image.mean(axis=2) < 110).nonzero()
    return None if rows.size == 0 else (columns[rows == rows.max()].mean(), rows.max())
'''

WHERE = """

def test_simtip_is_the_installed_one():
    import simtip

    print("FROM", simtip.__file__)
"""


class Environment:
    """A virtual environment; what simtip depends on is seen through to this one's packages."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        venv.create(folder, with_pip=False)
        self.python = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
        self.packages = Path(
            self.run("-c", "import sysconfig; print(sysconfig.get_path('purelib'))")
        )
        seen = [
            place for place in sys.path if Path(place).name in ("site-packages", "dist-packages")
        ]
        (self.packages / "dependencies.pth").write_text("\n".join(seen) + "\n")

    def run(self, *arguments: object, cwd: Path | None = None, code: int = 0) -> str:
        """Run Python, and give what it printed."""
        environment = {
            k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PYTEST"))
        }
        done = subprocess.run(
            [self.python, *map(str, arguments)],
            cwd=cwd or self.folder,
            env={**environment, "SIMTIP_CACHE": str(self.folder / "cache"), "NO_COLOR": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == code, done.stdout + done.stderr
        return done.stdout.strip()

    def install(self, source: Path) -> None:
        """Install a package by its wheel, without what it depends on."""
        wheels = self.folder / "wheels" / source.name
        build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(wheels)]
        subprocess.run(build, cwd=source, check=True, capture_output=True)
        (wheel,) = wheels.glob("*.whl")
        pip = [sys.executable, "-m", "pip", "--python", str(self.python), "install", "--quiet"]
        command = [*pip, "--no-deps", "--no-index", str(wheel)]
        subprocess.run(command, cwd=self.folder, check=True, capture_output=True)


@pytest.fixture(scope="module")
def environment(tmp_path_factory) -> Environment:
    """One with simtip's wheel in it."""
    made = Environment(tmp_path_factory.mktemp("separate"))
    made.install(ROOT)
    return made


@pytest.fixture(scope="module")
def package(environment, tmp_path_factory) -> Path:
    """A package with a detector and the test of docs/pytest.md, installed."""
    folder = tmp_path_factory.mktemp("my_tips")
    (folder / "my_tips").mkdir()
    (folder / "tests").mkdir()
    (folder / "pyproject.toml").write_text(PROJECT)
    (folder / "my_tips" / "__init__.py").write_text(DETECTOR)
    shutil.copy(ROOT / "simtip" / "regress" / "standard" / "bench.yaml", folder / "tests")
    shown = re.search(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)[1]
    test = "from my_tips import find_tip\n\n\n" + shown[shown.index("def test") :]
    (folder / "tests" / "test_my_detector.py").write_text(test + WHERE)
    environment.install(folder)
    return folder


def test_its_test_passes_and_leaves_nothing(environment, package):
    before = {path for path in package.rglob("*") if path.suffix != ".pyc"}
    said = environment.run("-m", "pytest", "-s", "-p", "no:cacheprovider", cwd=package)
    assert "2 passed" in said
    assert "warning" not in said.replace("my_tips", "").lower()
    assert "simtip-" in next(line for line in said.splitlines() if line.startswith("plugins:"))
    origin = Path(re.search(r"FROM (.*)", said)[1])
    assert origin == environment.packages / "simtip" / "__init__.py"
    after = {path for path in package.rglob("*") if path.suffix != ".pyc"}
    assert {path.name for path in after - before} <= {"__pycache__"}


def test_its_failing_test_leaves_a_picture(environment, package):
    strict = package / "tests" / "test_strict.py"
    body = (package / "tests" / "test_my_detector.py").read_text()
    strict.write_text(body.replace("px=8, mm=1", "px=1").replace(WHERE, ""))
    said = environment.run("-m", "pytest", strict, cwd=package, code=1)
    strict.unlink()
    assert "1 failed" in said
    assert "bench, seed 0: the tip is not within 1 px" in said
    assert re.search(r"left: 2\.\d\d px off, along \+2\.\d\d \(short of the tip\)", said)
    name = ".simtip-failures/tests/test_strict.py/test_the_tip_is_found/01_bench_seed_0.png"
    assert f"bench, seed 0: {name}" in said
    picture = read_image(package / name)
    assert picture.shape[0] == 700
    red, _, blue = np.moveaxis(picture.astype(int), -1, 0)
    assert (blue - red > 50).sum() > 50  # the true tip's mark
    assert (red - blue > 80).sum() > 50  # the detected tip's


def test_a_program_that_has_imported_simtip_may_run_pytest(environment, tmp_path):
    """pytest would rewrite the assertions of any package with a plug-in, and complain."""
    (tmp_path / "test_a.py").write_text("def test(): ...\n")
    program = "import simtip, pytest; pytest.main(['-W', 'error', '-q'])"
    said = environment.run("-c", program, cwd=tmp_path)
    assert "1 passed" in said
    assert "warning" not in said


def test_it_can_do_without(environment, package):
    said = environment.run("-m", "pytest", "-p", "no:simtip", cwd=package, code=1)
    assert "fixture 'simtip_pair' not found" in said
