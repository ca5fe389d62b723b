from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import pytest
from command_line import in_a_process, lay_out


@pytest.fixture
def bench(tmp_path, monkeypatch) -> Path:
    """A working folder with a good scene, rig and pair of images."""
    # Scalar: no test of a bad input waits for a trial of a GPU.
    monkeypatch.setenv("SIMTIP_BACKEND", "scalar")
    monkeypatch.chdir(tmp_path)
    return lay_out(tmp_path)


@dataclass(frozen=True)
class Ran:
    """A folder that `simtip run` has made, and what it said."""

    bench: Path
    folder: Path
    printed: dict
    stderr: str

    def saved(self, name: str) -> dict:
        return json.loads((self.folder / name).read_text())


@pytest.fixture(scope="session")
def ran(tmp_path_factory) -> Ran:
    """One real run in a process of its own, so that stdout is all that anyone wrote there."""
    bench = lay_out(tmp_path_factory.mktemp("ran"))
    done = in_a_process("run", "scene.yaml", "-o", "out", "--json", cwd=bench)
    assert done.returncode == 0, done.stderr
    return Ran(bench, bench / "out", json.loads(done.stdout), done.stderr)
