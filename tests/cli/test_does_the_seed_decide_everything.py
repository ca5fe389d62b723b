"""The same seed: the same bytes, from another process, too. Another seed: other noise."""

from __future__ import annotations

import json

import pytest
from command_line import in_a_process

pytestmark = pytest.mark.slow
IMAGES = ("left.png", "right.png", "left_mask.png", "right_mask.png")


def images(folder):
    return {name: (folder / name).read_bytes() for name in IMAGES}


def run(ran, out, *more):
    done = in_a_process("run", str(ran.bench / "scene.yaml"), "-o", "out", "--json", *more, cwd=out)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), out / "out"


def test_another_process_gives_the_same_bytes(ran, tmp_path):
    result, folder = run(ran, tmp_path)
    assert images(folder) == images(ran.folder)
    assert result | {"timings_s": None} == ran.printed | {"timings_s": None}


def test_the_saved_scene_gives_the_same_bytes(ran, tmp_path):
    """With --seed, the folder's scene holds the seed that was used."""
    _, first = run(ran, tmp_path, "--seed", "11")
    done = in_a_process("render", str(first / "scene.yaml"), "-o", "again", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert images(tmp_path / "again") == images(first)
    assert images(first)["left.png"] != images(ran.folder)["left.png"]
    assert images(first)["right.png"] != images(ran.folder)["right.png"]
