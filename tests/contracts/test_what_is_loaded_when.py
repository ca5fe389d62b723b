"""What a plain import and the commands that do not render load, and who may draw plots."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import simtip
from simtip.image_file import write_png
from simtip.rig_file import rig_text
from simtip.scene_file import load_scene

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes" / "01_single_tip.yaml"
HEAVY = {"mitsuba", "drjit"}
PLOTTING = {"altair", "bokeh", "matplotlib", "plotly", "pylab", "pyqtgraph", "pyvista", "seaborn"}

COMMANDS = (
    ["--help"],
    ["run", "--help"],
    ["--version"],
    ["schema"],
    ["rig", str(SCENE)],
    ["measure", "--rig", "rig.yaml", "left.png", "right.png", "--json"],
    ["detect", "left.png", "--json"],
    ["detectors"],
)

# One process does all of it in turn and says after each step what it has loaded.
STEPS = """
import json, sys
def tell(step):
    loaded = sorted(name for name in sys.modules if "." not in name)
    print("LOADED", json.dumps([step, loaded]))
import simtip
tell("import simtip")
import simtip.render
tell("import simtip.render")
from simtip.cli import main
for argv in json.loads(sys.argv[1]):
    try:
        main(argv)
    except SystemExit as ended:
        assert not ended.code, argv
    tell(" ".join(argv))
if len(sys.argv) > 2:
    import simtip.render.engine
    tell("import simtip.render.engine")
"""


def loaded_after(folder: Path, *more: str) -> dict[str, set[str]]:
    done = subprocess.run(
        [sys.executable, "-c", STEPS, json.dumps(COMMANDS), *more],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
    )
    assert done.returncode == 0, done.stderr
    told = [line.removeprefix("LOADED ") for line in done.stdout.splitlines() if "LOADED " in line]
    return {step: set(names) for step, names in map(json.loads, told)}


@pytest.mark.slow
def test_only_a_render_loads_mitsuba_and_drjit(tmp_path):
    for name in ("left.png", "right.png"):
        write_png(tmp_path / name, np.full((100, 80), 200, np.uint8))
    rig = rig_text(load_scene(SCENE).rig.rig())
    (tmp_path / "rig.yaml").write_text(rig.replace("image_", "other_"))  # any size will do
    told = loaded_after(tmp_path, "and the engine")
    last = told.pop("import simtip.render.engine")
    assert last >= HEAVY, "the list does not show what is loaded"
    assert len(told) == 2 + len(COMMANDS)
    for step, names in told.items():
        assert "simtip" in names
        assert not names & (HEAVY | PLOTTING), step


def imported(source: str) -> set[str]:
    """Give the top-level packages that a module's text imports, anywhere in it."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add((node.module or "").partition(".")[0])
    return names


def test_nothing_but_the_report_imports_a_plotting_library():
    files = [
        file
        for file in (ROOT / "simtip").rglob("*.py")
        if "report" not in file.relative_to(ROOT / "simtip").parts[0]
    ]
    assert len(files) > 20
    for file in files:
        source = file.read_text()
        # what is imported is written out: a text without any of the names need not be parsed
        assert not any(name in source for name in PLOTTING) or not imported(source) & PLOTTING, file


def test_a_late_import_of_a_plotting_library_would_be_seen():
    assert imported("def draw():\n    from matplotlib import pyplot\n") == {"matplotlib"}


def test_the_package_is_typed_and_documented_where_it_opens():
    assert (ROOT / "simtip" / "py.typed").is_file()
    for name in simtip.__all__:
        documented = getattr(simtip, name)
        assert name == "__version__" or documented.__doc__, name
