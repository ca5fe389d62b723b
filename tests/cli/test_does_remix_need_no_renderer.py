"""Does the command line store light and mix it again, with every mistake one line?"""

from __future__ import annotations

import contextlib
import json
import shutil
from pathlib import Path

import pytest
from asked import call
from command_line import SCENE

FRONT = "{name: front, kind: tube,"


@pytest.fixture(scope="module")
def rendered(tmp_path_factory) -> Path:
    """A folder with rendered light, and its scene beside it."""
    folder = tmp_path_factory.mktemp("rendered")
    (folder / "scene.yaml").write_text(SCENE, encoding="utf-8")
    with contextlib.chdir(folder):
        answer = call("render", "scene.yaml", "-o", "lit", "--lights")
    assert answer.code == 0, answer.err
    return folder


@pytest.fixture
def lit(tmp_path, monkeypatch, rendered):
    """A copy of that folder, with other scenes."""
    shutil.copytree(rendered, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    dimmed = SCENE.replace(FRONT, f"{FRONT} power: 0.5,")
    (tmp_path / "dimmed.yaml").write_text(dimmed, encoding="utf-8")
    moved = SCENE.replace(FRONT, f"{FRONT} length_mm: 900,")
    (tmp_path / "moved.yaml").write_text(moved, encoding="utf-8")
    return tmp_path


def test_a_dimmed_lamp_is_mixed_and_a_moved_one_refused(lit, ask):
    mixed = ask("remix", "lit", "dimmed.yaml", "-o", "dim", "--json")
    assert mixed.code == 0, mixed.err
    assert set(json.loads(mixed.out)["timings_s"]) == {"sensor"}
    bright, dim = ((lit / name / "left.png").read_bytes() for name in ("lit", "dim"))
    assert bright != dim
    manifest = json.loads((lit / "dim" / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["backend"]["reason"] == "light groups read from lit"

    again = ask("remix", "lit", "dimmed.yaml", "-o", "dim")
    assert again.code == 2
    other = ask("remix", "lit", "moved.yaml", "-o", "other")
    assert other.code == 2
    assert "moved.yaml:" in other.err
    assert "lamps[0].length_mm" in other.err
    assert not (lit / "other").exists()


def test_another_seed_changes_the_sensors_noise_and_not_the_scene(lit, ask):
    assert ask("remix", "lit", "-o", "new", "--seed", "9").code == 0
    manifest = json.loads((lit / "new" / "manifest.json").read_text(encoding="utf-8"))
    assert (manifest["seed"], manifest["light_seed"]) == (9, 3)
    assert "seed: 3" in (lit / "new" / "scene.yaml").read_text(encoding="utf-8")


@pytest.mark.usefixtures("lit")
def test_a_folder_without_light_is_one_line(ask):
    answer = ask("remix", ".", "-o", "x")
    assert answer.code == 2
    assert "left_lights.exr: no such file" in answer.err
