"""Which meshes and texts are needles, and what is taken from them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from simtip.errors import InputError
from simtip.needle import (
    BackBevel,
    Bevel,
    Blunt,
    Cone,
    Diamond,
    Franseen,
    Lancet,
    Needle,
    Trocar,
)
from simtip.refine import Solid, named, read_solid

ASSETS = Path(__file__).resolve().parents[2] / "assets" / "needle_18g"
TIPS = {
    "cone": (Cone(5.0), 0, True, True),
    "round cone": (Cone(5.0, 0.1), 0, True, True),
    "bevel": (Bevel(20.0), 1, False, False),
    "round bevel": (Bevel(20.0, 0.01), 1, False, False),
    "lancet": (Lancet(12.0), 3, False, False),
    "back bevel": (BackBevel(12.0), 3, False, False),
    "trocar": (Trocar(20.0), 3, False, False),
    "diamond": (Diamond(20.0), 4, False, False),
    "blunt": (Blunt(), 1, False, True),
}


@pytest.mark.parametrize("name", TIPS)
def test_facets_and_symmetry_are_seen(name):
    tip, facets, curved, revolution = TIPS[name]
    needle = Needle(1.67, 60.0, tip)
    solid = Solid.from_mesh(*needle.surface(256), needle.apex)
    assert (len(solid.facets), solid.curved, solid.revolution) == (facets, curved, revolution)
    assert solid.radius_mm == pytest.approx(0.835)
    assert solid.depth_mm == pytest.approx(tip.depth_mm(0.835), abs=5e-3)
    np.testing.assert_allclose(solid.apex, needle.apex, atol=1e-9)


@pytest.mark.parametrize(
    "needle",
    [
        Needle(1.67, 60.0, Franseen(20.0)),
        Needle(1.67, 60.0, Cone(5.0), bend_radius_mm=300.0),
    ],
    ids=["crown", "bent"],
)
def test_what_is_not_convex_is_refused(needle):
    with pytest.raises(InputError, match=r"convex|bent"):
        Solid.from_mesh(*needle.surface(128), needle.apex)


def test_frames_that_are_not_the_needles_are_refused():
    vertices, faces = Needle(1.67, 60.0, Cone(5.0)).surface(64)
    wrong = {
        "no needle along z": vertices[:, [2, 0, 1]],
        "off the z axis": vertices + np.array([3.0, 0, 0]),
        "small end of z": vertices * [1, 1, -1],
    }
    for words, points in wrong.items():
        turned = faces[:, ::-1] if words == "small end of z" else faces
        with pytest.raises(InputError, match=words):
            Solid.from_mesh(points, turned)
    with pytest.raises(InputError, match="inside out"):
        Solid.from_mesh(vertices, faces[:, ::-1])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "text"),
    [("needle_18g.ply", "cone:1.67:5"), ("needle_18g_bevel.ply", "bevel:1.67:20")],
)
def test_text_and_mesh_file_are_the_same_needle(file, text, tmp_path):
    one, other = read_solid(ASSETS / file), named(text)
    mesh = trimesh.load(ASSETS / file, process=False)
    mesh.export(tmp_path / "needle.STL")
    for solid in (one, read_solid(tmp_path / "needle.STL")):
        np.testing.assert_allclose(solid.apex, other.apex, atol=1e-4)
        assert solid.depth_mm == pytest.approx(other.depth_mm, abs=1e-4)
        assert (solid.curved, solid.revolution) == (other.curved, other.revolution)
        assert len(solid.facets) == len(other.facets)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("cone:1.67", "names no needle"),
        ("cone:a:b", "names no needle"),
        ("sphere:1:2", "names no needle"),
        ("cone:-1:5", "diameter"),
        ("cone:nan:5", "diameter"),
        ("cone:1.67:inf", "cone is inf mm"),
        ("bevel:1.67:90", "angle"),
    ],
)
def test_a_text_that_names_none_is_told(text, words):
    with pytest.raises(InputError, match=words):
        named(text)


@pytest.mark.parametrize("suffix", ["ply", "stl"])
@pytest.mark.parametrize(
    "data",
    [
        b"garbage",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 999999999999\nend_header\n",
        b"\0" * 84,
        b"\xff" * 500,
        b"solid x\nfacet normal 0 0 1\nendsolid",
    ],
    ids=["text", "claims much", "no faces", "bytes", "cut short"],
)
def test_a_damaged_file_is_one_line(data, suffix, tmp_path):
    file = tmp_path / f"needle.{suffix}"
    file.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_solid(file)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_other_kinds_of_file_are_refused(tmp_path):
    with pytest.raises(InputError, match="neither"):
        read_solid(tmp_path / "needle.obj")
    with pytest.raises(InputError, match="no such file"):
        read_solid(tmp_path / "needle.ply")
