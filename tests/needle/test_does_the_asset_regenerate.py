"""Are the meshes in assets/needle_18g what their source parameters make?"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
import yaml

from simtip.needle import Bevel, Cone, Needle
from simtip.spec import NeedleSpec

ASSET = Path(__file__).parents[2] / "assets" / "needle_18g"
NEEDLES = {
    "needle_18g.ply": Needle(1.67, 150.0, Cone(5.0)),
    "needle_18g_bevel.ply": Needle(1.67, 150.0, Bevel(20.0)),
}


@pytest.fixture(scope="module")
def regenerated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("needle")
    script = ASSET / "regenerate.py"
    subprocess.run([sys.executable, script, folder], check=True, capture_output=True)
    return folder


def test_the_parameters_name_exactly_the_meshes():
    parameters = yaml.safe_load((ASSET / "parameters.yaml").read_text(encoding="utf-8"))
    assert set(parameters["meshes"]) == set(NEEDLES) == {p.name for p in ASSET.glob("*.ply")}


@pytest.mark.slow
@pytest.mark.parametrize("name", NEEDLES)
def test_regenerating_gives_the_same_mesh(regenerated, name):
    """Arrays, not bytes: another trimesh may word the header anew."""
    stored, made = (trimesh.load(f / name, process=False) for f in (ASSET, regenerated))
    np.testing.assert_array_equal(stored.vertices, made.vertices)
    np.testing.assert_array_equal(stored.faces, made.faces)


@pytest.mark.parametrize("name", NEEDLES)
def test_the_stored_mesh_is_the_needle_in_single_precision(name):
    stored = trimesh.load(ASSET / name, process=False)
    vertices, faces = NEEDLES[name].surface()
    np.testing.assert_array_equal(stored.vertices.astype(np.float32), vertices.astype(np.float32))
    np.testing.assert_array_equal(stored.faces, faces)
    assert stored.is_watertight
    assert stored.volume > 0
    assert (ASSET / name).stat().st_size < 200_000


def test_the_first_mesh_is_the_default_needle_of_a_scene():
    assert NeedleSpec(tip_mm=(0, 0, 0)).needle() == NEEDLES["needle_18g.ply"]
