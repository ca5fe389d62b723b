"""Is the site built without a warning, is it whole by itself, and do faults in pages end it?"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from importlib import import_module

import pytest
from pages import PAGES, ROOT
from typer.main import get_command

import simtip
from simtip.cli import app
from simtip.spec import SceneSpec

pytest.importorskip("mkdocs")
HOOKS = ROOT / "docs" / "hooks"


def build(root, out) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(out)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        command, cwd=root, env=environment, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    out = tmp_path_factory.mktemp("site") / "site"
    done = build(ROOT, out)
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture
def hook(monkeypatch):
    monkeypatch.syspath_prepend(str(HOOKS))
    return import_module


@pytest.mark.slow
def test_every_page_is_in_the_site(site):
    for page in PAGES[1:]:
        assert (site / page.relative_to(ROOT / "docs").with_suffix(".html")).is_file()
    for name in ("index", "changelog", "speed", "needle_mesh", "files/scenes", "files/detectors"):
        assert (site / f"{name}.html").is_file()


@pytest.mark.slow
def test_every_command_and_field_is_in_the_reference(site):
    told = (site / "reference" / "cli.html").read_text(encoding="utf-8")
    for command in get_command(app).commands:
        assert f'id="simtip-{command}"' in told
    fields = (site / "reference" / "scene_fields.html").read_text(encoding="utf-8")
    for field in SceneSpec.model_fields:
        assert f"<code>{field}</code>" in fields


def test_every_public_name_is_on_the_page_on_python():
    page = (ROOT / "docs" / "reference" / "python.md").read_text(encoding="utf-8")
    told = set(re.findall(r"^::: simtip\.([\w.]+)$", page, re.MULTILINE))
    assert told == set(simtip.__all__) - {"__version__"} | {"detect.Detector"}


@pytest.mark.slow
def test_nothing_is_loaded_from_elsewhere(site):
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        loaded = re.findall(
            r'<(?:script|link|img|iframe)[^>]*(?:src|href)="(https?://[^"]+)"', text
        )
        assert not loaded, page
    for style in site.rglob("*.css"):
        assert not re.search(r"url\(['\"]?https?:", style.read_text(encoding="utf-8")), style


@pytest.mark.slow
def test_faults_in_pages_end_the_build_and_are_named(tmp_path):
    for name in ("docs", "scenes", "examples", "benchmarks", "assets", "simtip/regress/standard"):
        shutil.copytree(ROOT / name, tmp_path / name)
    for name in ("README.md", "CHANGELOG.md", "mkdocs.yml"):
        shutil.copy(ROOT / name, tmp_path / name)
    (tmp_path / "docs" / "unlisted.md").write_text("# Unlisted\n", encoding="utf-8")
    faults = ("nowhere.md", "conventions.md#nowhere", "../simtip/trial.py", "images/nothing.jpg")
    with (tmp_path / "docs" / "scaling.md").open("a", encoding="utf-8") as page:
        page.writelines(f"\n[A fault]({fault}).\n" for fault in faults)
    done = build(tmp_path, tmp_path / "site")
    assert done.returncode == 1
    assert done.stderr.count("WARNING") == len(faults) + 1
    for said in (*faults, "unlisted.md"):
        assert said in done.stderr


@pytest.mark.parametrize(
    ("path", "folder", "uri", "there"),
    [
        ("docs/sweeps.md", "", "index.md", "sweeps.md"),
        ("docs/images/pair.jpg", "", "index.md", "images/pair.jpg"),
        ("../README.md", "docs", "paper.md", "index.md"),
        ("../scenes/hard", "docs", "detectors.md", "files/hard_scenes.md"),
        ("../scenes/paper/lin2020.yaml", "docs", "paper.md", "files/paper_scene.md#lin2020.yaml"),
        ("../conventions.md", "docs/tutorials", "tutorials/sweep.md", "../conventions.md"),
        ("../docs/detectors.md", "benchmarks", "speed.md", "detectors.md"),
    ],
)
def test_a_link_in_the_repository_is_one_in_the_site(path, folder, uri, there, hook):
    assert hook("repository_files").site_link(path, "", folder, uri) == there


def test_a_table_of_fields_tells_type_default_and_place(hook):
    schema = {
        "properties": {
            "count": {"type": "integer", "minimum": 1, "default": 3, "description": "How | many."},
            "part": {"anyOf": [{"$ref": "#/$defs/Part"}, {"type": "null"}], "default": None},
        },
        "required": [],
        "$defs": {
            "Part": {
                "description": "A part.\n\nMore.",
                "properties": {"place": {"prefixItems": [{"type": "number"}], "type": "array"}},
                "required": ["place"],
            }
        },
    }
    page = hook("schema_tables").schema_page("T", "O.", schema)
    assert "| `count` | integer from 1 | `3` | How \\| many. |" in page
    assert "| `part` | [mapping](#part), or null | `null` |  |" in page
    assert "## part {: #part }\n\nA part.\n\n" in page
    assert "| `place` | list of (number) | **required** |  |" in page
