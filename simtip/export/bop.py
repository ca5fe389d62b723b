"""BOP's scenes (`docs/bop_datasets_format.md` of bop_toolkit): one a folder, two images a pair."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from simtip.errors import InputError
from simtip.export.bop_model import model_info, write_model
from simtip.export.bop_view import BEYOND, BopView
from simtip.export.eight_bit import eight_bit
from simtip.export.json_stream import JsonArray, JsonObject
from simtip.export.pinhole import undistorted, without_distortion
from simtip.export.sources import source_rows
from simtip.export.tracer import Tracer
from simtip.image_file import write_png
from simtip.image_sets import NeedleImages, NeedlePair
from simtip.image_sets.pairs import SIDES
from simtip.needle import Needle
from simtip.render import Backend

SPLIT = "test"

LEAST_VISIBLE = 0.1
"""Share of a needle that makes it a target, as in the BOP Challenge."""

FIELDS = ("scene_camera", "scene_gt", "scene_gt_info")

ABOUT = """\
Rendered needles. Model frame, mm: z along the needle's axis from the tip to the hub, the axis at
x = y = 0, the foremost point at z = 0. `models/tips.json` says where each model's tip is.

World frame: the left camera's of each pair. Image 2k is the left one of pair k, 2k + 1 the right
one; between pairs the needle may move. Pixel (0, 0) is the centre of the top-left pixel, in K as in
OpenCV. Masks and depth are of pixel centres, as a pinhole sees them; depth is exact.
"""


def write_bop(
    folder: Path,
    sets: Sequence[NeedleImages],
    *,
    backend: Backend,
    undistort: bool,
    done: Callable[[], None],
) -> None:
    """Write some sets of pairs as BOP scenes.

    Parameters
    ----------
    folder
        An empty one.
    sets
        One a scene.
    backend
        What traces depth and masks.
    undistort
        Whether images of lenses with distortion are resampled, since BOP knows pinholes only.
    done
        Called after each pair.

    Raises
    ------
    InputError
        A lens has distortion, and `undistort` is not given; or a pair cannot be read.
    """
    models, tracer = _Models(folder / "models"), Tracer(backend, BEYOND)
    with ExitStack() as opened:
        sources = opened.enter_context(source_rows(folder))
        targets = opened.enter_context(JsonArray(folder / "test_targets_bop19.json"))
        for number, one in enumerate(sets):
            with ExitStack() as files_of_scene:
                scene = _Scene(folder, number, models, targets, files_of_scene)
                for pair in one.pairs():
                    files = scene.add(_views(pair, tracer, undistort=undistort), pair)
                    named = {"source": pair.source, "label": pair.label}
                    sources.add(dict(zip(SIDES, files, strict=True)) | named)
                    done()
    models.finish()
    (folder / "dataset_info.md").write_text(ABOUT, encoding="utf-8")


def _views(pair: NeedlePair, tracer: Tracer, *, undistort: bool) -> list[BopView]:
    rig = pair.truth.rig
    cameras = rig.left, rig.right
    if any(camera.distortion for camera in cameras) and not undistort:
        raise InputError(
            f"BOP knows no distortion of lenses, and {pair.source} has some",
            field="--format",
            remedy="give --undistort to resample the images, or take another format",
        )
    plain = without_distortion(rig)
    seen = tracer.trace(pair.spec, plain)
    views = []
    for image, taken, camera, T_cw, surfaces in zip(
        pair.images, cameras, (plain.left, plain.right), pair.poses, seen, strict=True
    ):
        resampled, known = undistorted(image, taken)
        stored = eight_bit(resampled, pair.spec.sensor.bit_depth)
        views.append(BopView(stored, camera, T_cw, T_cw @ pair.truth.T_wn, surfaces, known))
    return views


class _Scene:
    """A scene's folder, filled pair by pair."""

    def __init__(
        self, root: Path, number: int, models: _Models, targets: JsonArray, opened: ExitStack
    ) -> None:
        self._root, self._number = root, number
        self._models, self._targets = models, targets
        self._folder = root / SPLIT / f"{number:06d}"
        self._image = 0
        for name in ("rgb", "depth", "mask", "mask_visib"):
            (self._folder / name).mkdir(parents=True)
        self._files = {
            name: opened.enter_context(JsonObject(self._folder / f"{name}.json")) for name in FIELDS
        }

    def add(self, views: Iterable[BopView], pair: NeedlePair) -> list[str]:
        """Write both images of a pair, and give their files' names."""
        model = self._models.number_of(pair.truth.needle)
        names = []
        for view in views:
            name = f"{self._image:06d}"
            depth, scale = view.depth()
            write_png(self._folder / "rgb" / f"{name}.png", view.image)
            write_png(self._folder / "depth" / f"{name}.png", depth)
            for kind, mask in (("mask", view.mask), ("mask_visib", view.mask_visib)):
                write_png(
                    self._folder / kind / f"{name}_000000.png",
                    mask.astype(np.uint8) * np.uint8(255),
                )
            info = view.info_entry(depth)
            key = str(self._image)
            self._files["scene_camera"].add(key, view.camera_entry(scale))
            self._files["scene_gt"].add(key, [view.pose_entry(model)])
            self._files["scene_gt_info"].add(key, [info])
            if info["visib_fract"] >= LEAST_VISIBLE:
                self._targets.add(
                    {"im_id": self._image, "inst_count": 1, "obj_id": model}
                    | {"scene_id": self._number}
                )
            if not self._number and not self._image:
                self._write_camera(view, scale)
            names.append(f"{self._folder.relative_to(self._root).as_posix()}/rgb/{name}.png")
            self._image += 1
        return names

    def _write_camera(self, view: BopView, scale: float) -> None:
        """Write ``camera.json``, which is for the simulation of a sensor only: the first one."""
        K, camera = view.camera.K, view.camera
        told = {
            "cx": float(K[0, 2]),
            "cy": float(K[1, 2]),
            "depth_scale": scale,
            "fx": float(K[0, 0]),
            "fy": float(K[1, 1]),
            "height": camera.height,
            "width": camera.width,
        }
        (self._root / "camera.json").write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")


class _Models:
    """The object models: one of each needle that there is, written when it is first met."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._numbers: dict[Needle, int] = {}
        self._info: dict[str, Any] = {}
        self._tips: dict[str, Any] = {}
        folder.mkdir()

    def number_of(self, needle: Needle) -> int:
        """Give the needle's obj_id, from 1."""
        if needle not in self._numbers:
            number = self._numbers[needle] = len(self._numbers) + 1
            write_model(self._folder / f"obj_{number:06d}.ply", needle)
            self._info[str(number)] = model_info(needle)
            self._tips[str(number)] = {
                "kind": needle.tip.kind,
                "tip_mm": needle.apex.tolist(),
                "axis": [0.0, 0.0, 1.0],
            }
        return self._numbers[needle]

    def finish(self) -> None:
        """Write what is said of all of them."""
        for name, told in (("models_info", self._info), ("tips", self._tips)):
            text = json.dumps(told, indent=1, allow_nan=False) + "\n"
            (self._folder / f"{name}.json").write_text(text, encoding="utf-8")
