"""A reader's folder, and what a reader does there with the blocks of a page."""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import shell
import yaml
from pages import ROOT, Block
from small_scenes import copy_scenes, quarter, region

from simtip.scene_file import dump_scene, load_scene

SCENE = "scenes/01_single_tip.yaml"


def furnish(folder: Path) -> None:
    """Put there what the pages presume: the repository's scenes and examples, the reader's files.

    Capital names are those that stand in the pages for any file of their kind.
    """
    copy_scenes(ROOT / "scenes", folder / "scenes")
    shutil.copytree(ROOT / "examples", folder / "examples")
    scene = (folder / SCENE).read_text(encoding="utf-8")
    (folder / "SCENE").write_text(scene, encoding="utf-8")
    dimmed = scene.replace("power: 1.0", "power: 0.5", 1)
    assert dimmed != scene
    (folder / "SCENE2").write_text(dimmed, encoding="utf-8")
    sweep = {"scene": "SCENE", "factors": {"detect.threshold": [90, 105]}}
    (folder / "SWEEP").write_text(yaml.safe_dump(sweep), encoding="utf-8")
    suite = {"name": "few", "scene": "SCENE", "repeats": 2, "cases": [{"name": "nominal"}]}
    (folder / "SUITE").write_text(yaml.safe_dump(suite), encoding="utf-8")
    bench = region(load_scene(ROOT / "simtip" / "regress" / "standard" / "bench.yaml"))
    (folder / "bench.yaml").write_text(dump_scene(bench), encoding="utf-8")
    (folder / "CSV").write_text(measurements(), encoding="utf-8")
    for name in ("needle.csv", "gauge.csv"):
        shutil.copy(folder / "CSV", folder / name)
    whole = dump_scene(quarter(load_scene(ROOT / SCENE)))
    (folder / "whole.yaml").write_text(whole, encoding="utf-8")
    answer = shell.call("render", str(folder / "whole.yaml"), "-o", str(folder / "seen"))
    assert answer.code == 0, answer.err
    for name, of in (("left", "left"), ("right", "right"), ("photo", "left")):
        shutil.copy(folder / "seen" / f"{of}.png", folder / f"{name}.png")
    shutil.rmtree(folder / "seen")


def measurements() -> str:
    """Write measurements of five parts by two operators, three times each."""
    rows = [
        f"{p},{o},{t},{2 * p},{2 * p + 0.29 + 0.01 * t + 0.02 * o},{2 * p + 0.001}"
        for p in range(1, 6)
        for o in range(2)
        for t in range(3)
    ]
    return "\n".join(["part,operator,trial,reference,measured,xl80", *rows])


def read(blocks: list[Block], folder: Path) -> None:
    """Do what a page's blocks say, in their order; the working folder has to be `folder`."""
    names: dict[str, Any] = {"__name__": "page"}
    printed: str | None = None
    for block in blocks:
        before, printed = printed, None
        if block.not_run is not None:
            continue
        if block.file is not None:
            (folder / block.file).parent.mkdir(parents=True, exist_ok=True)
            (folder / block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "sh":
            printed = shell.run(block, folder)
        elif block.language == "python":
            exec(compile(block.text, block.place, "exec"), names)  # noqa: S102 (our own pages)
        elif block.language in {"text", "json"} and block.follows and before is not None:
            check_shape(block, before)
    forget_modules(folder)


def check_shape(shown: Block, printed: str) -> None:
    """Check that all words, or all JSON keys, that a page shows as output were printed."""
    if shown.language == "json":
        missing = keys(json.loads(shown.text)) - keys(json.loads(printed))
    else:
        missing = words(shown.text) - words(printed)
    assert not missing, f"{shown.place}: shows {sorted(missing)}, which was not printed"


def words(text: str) -> set[str]:
    """Give all words: letters, not digits, for those may differ."""
    return set(re.findall(r"[A-Za-z][A-Za-z_]+", text))


def keys(value: Any) -> set[str]:
    """Give the keys of all mappings in a JSON value."""
    if isinstance(value, dict):
        return set(value).union(*map(keys, value.values()))
    return set().union(*map(keys, value)) if isinstance(value, list) else set()


def forget_modules(folder: Path) -> None:
    """Let the next page have modules of the same names."""
    for name, module in list(sys.modules.items()):
        file = getattr(module, "__file__", None)
        if file and Path(file).is_relative_to(folder):
            del sys.modules[name]
