"""A folder of calibration images that fills up view by view, and can be filled up later.

``truth.json``, ``rig_true.yaml`` and ``scene.yaml`` are there from the start; each image appears
whole or not at all. Which images are there is all the state there is.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from simtip.boards import BoardSet, picture_board
from simtip.errors import InputError
from simtip.image_file import write_png
from simtip.input_file import read_bytes
from simtip.output_folder import PREFIX, OutputFolder, result_folder
from simtip.provenance import backend_facts, environment
from simtip.render import Backend, require_boards
from simtip.rig_file import rig_text
from simtip.scene_file import dump_scene
from simtip.spec import SceneSpec

TRUTH = "truth.json"
DIGEST = "inputs_sha256"
BESIDE_TRUTH = {DIGEST, "seed", "rig", "made_by"}
"""What stands in ``truth.json`` besides `BoardSet.truth`."""

MAX_TRUTH_BYTES = 1 << 30

PNG_END = b"IEND\xaeB`\x82"
"""Name and check sum of every PNG's last chunk, which is empty."""

IRRELEVANT = {"name", "seed", "detect", "match", "triangulate"}
"""Parts of a scene that no image of a board depends on."""

Report = Callable[[float], None]


def fill_folder(
    folder: Path, boards: BoardSet, *, backend: Backend, progress: Report
) -> tuple[int, int]:
    """Render all views that a folder lacks.

    Parameters
    ----------
    folder
        New or empty, or one that this function began with the same set.
    boards
        The set.
    backend
        What renders.
    progress
        Called with the fraction of all views done.

    Returns
    -------
    rendered, found
        How many views were rendered, and how many were there already.

    Raises
    ------
    InputError
        The folder holds something else, or cannot be written; or the back end renders no boards.
    """
    require_boards(backend)
    _begin(folder, boards, backend)
    names = [boards.name(k) for k in range(len(boards.poses))]
    missing = [k for k, name in enumerate(names) if not all(map(_is_whole, _pair(folder, name)))]
    done = len(names) - len(missing)
    for count, k in enumerate(missing):
        before = done + count

        def report(part: float, before: int = before) -> None:
            progress((before + part) / len(names))

        images = picture_board(boards, k, backend=backend, progress=report)
        for path, image in zip(_pair(folder, names[k]), images, strict=True):
            write_png(path, image)
        progress((before + 1) / len(names))
    return len(missing), done


def check_folder(folder: Path, boards: BoardSet) -> None:
    """Refuse early a folder that `fill_folder` would refuse.

    Raises
    ------
    InputError
        The folder holds something else, or cannot be written.
    """
    if not (folder / TRUTH).is_file():
        OutputFolder(folder).check()
        return
    found = _digest_in(folder / TRUTH)
    if found != digest(boards):
        what = "something else than calibration images"
        if found is not None:
            what = "calibration images of another scene, target, seed or number of views"
        raise InputError(f"holds {what}", file=folder, remedy="name another folder")


def digest(boards: BoardSet) -> str:
    """Give the SHA-256, in hexadecimal, of all that decides the images."""
    return inputs_digest(boards.spec, boards.seed, boards.truth())


def inputs_digest(spec: SceneSpec, seed: int, truth: dict[str, Any]) -> str:
    """Give it of a set's scene, seed and truth, as ``truth.json`` has them."""
    scene = spec.model_dump(mode="json", exclude=IRRELEVANT)
    del scene["rig"]["measured"]
    inputs = {"seed": seed, "scene": scene, "truth": truth}
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def _begin(folder: Path, boards: BoardSet, backend: Backend) -> None:
    check_folder(folder, boards)
    if (folder / TRUTH).is_file():
        for left_over in folder.glob(f"{PREFIX}*"):
            left_over.unlink(missing_ok=True)  # of a run that was killed while writing
        return
    truth = {
        DIGEST: digest(boards),
        "seed": boards.seed,
        **boards.truth(),
        "rig": json.loads(rig_text(boards.spec.rig.rig(), "json")),
        "made_by": {**environment(), "backend": backend_facts(backend)},
    }
    rig = boards.spec.rig.model_copy(update={"measured": None})  # nothing is measured here
    scene = boards.spec.model_copy(update={"seed": boards.seed, "rig": rig})
    with result_folder(folder) as new:
        (new / "scene.yaml").write_text(dump_scene(scene), encoding="utf-8")
        (new / "rig_true.yaml").write_text(rig_text(boards.spec.rig.rig()), encoding="utf-8")
        text = json.dumps(truth, indent=1, allow_nan=False) + "\n"
        (new / TRUTH).write_text(text, encoding="utf-8")


def _pair(folder: Path, name: str) -> tuple[Path, Path]:
    return folder / f"left_{name}.png", folder / f"right_{name}.png"


def _is_whole(image: Path) -> bool:
    """Say whether a PNG is there to its last byte: copying or a power failure may cut it short."""
    try:
        with image.open("rb") as stream:
            stream.seek(-len(PNG_END), os.SEEK_END)
            return stream.read() == PNG_END
    except OSError:
        return False


def _digest_in(path: Path) -> str | None:
    try:
        found: Any = json.loads(read_bytes(path, MAX_TRUTH_BYTES))
    except (ValueError, RecursionError):
        return None
    digest_there = found.get(DIGEST) if isinstance(found, dict) else None
    return digest_there if isinstance(digest_there, str) else None
