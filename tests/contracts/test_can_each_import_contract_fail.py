"""The import contracts of pyproject.toml hold, and a planted violation breaks each of them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

pytest.importorskip("importlinter", reason="import-linter comes with the test dependencies")

ROOT = Path(__file__).resolve().parents[2]
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"][
    "contracts"
]
LINT = (
    "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports(no_cache=True))"
)


@pytest.fixture
def copy(tmp_path) -> Path:
    """The package and its contracts, to be spoilt."""
    shutil.copytree(ROOT / "simtip", tmp_path / "simtip", ignore=shutil.ignore_patterns("*.pyc"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def lint(folder: Path) -> tuple[int, str]:
    done = subprocess.run(
        [sys.executable, "-c", LINT],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder), "COLUMNS": "200", "NO_COLOR": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout + done.stderr


def plant(folder: Path, module: str, line: str) -> None:
    """Add a line to the end of a module."""
    file = folder.joinpath(*module.split("."))
    file = file / "__init__.py" if file.is_dir() else file.with_suffix(".py")
    file.write_text(f"{file.read_text()}\n{line}\n")


def broken(output: str) -> set[str]:
    return set(re.findall(r"^(.+) BROKEN", output, re.MULTILINE))


def test_the_contracts_hold():
    code, output = lint(ROOT)
    assert code == 0, output
    assert broken(output) == set()
    assert output.count(" KEPT") == len(CONTRACTS) >= 3


@pytest.mark.parametrize(
    "contract",
    [CONTRACTS[0], *(pytest.param(c, marks=pytest.mark.slow) for c in CONTRACTS[1:])],
    ids=lambda contract: contract["name"],
)
def test_a_violation_in_any_module_breaks_the_contract(contract, copy):
    forbidden = contract["forbidden_modules"][0]
    sources = contract["source_modules"]
    # The whole package as the source: one module of it that may not is enough.
    sources = ["simtip.sensor"] if sources == ["simtip"] else sources
    for source in sources:
        plant(copy, source, f"import {forbidden}")
    code, output = lint(copy)
    assert code == 1, output
    assert contract["name"] in broken(output)
    for source in sources:
        assert re.search(rf"{source}(\.\w+)* -> {forbidden}", output), f"{source} goes unnoticed"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "forbidden", "name"),
    [
        (
            "simtip.render.view",
            "simtip.match",
            "The simulation knows nothing of the measuring wing",
        ),
        (
            "simtip.detect.lin2020",
            "simtip.truth",
            "The measuring wing knows nothing of the simulat",
        ),
        ("simtip.cli", "drjit", "Only render loads Mitsuba"),
    ],
)
def test_a_violation_deep_inside_is_found(source, forbidden, name, copy):
    plant(copy, source, f"def late():\n    import {forbidden}")
    code, output = lint(copy)
    assert code == 1, output
    assert any(found.startswith(name) for found in broken(output))


def test_every_module_named_in_a_contract_exists():
    """A renamed module would slip out of its contract."""
    for contract in CONTRACTS:
        for module in contract["source_modules"] + contract["forbidden_modules"]:
            if module.startswith("simtip"):
                file = ROOT.joinpath(*module.split("."))
                assert file.is_dir() or file.with_suffix(".py").is_file(), module
