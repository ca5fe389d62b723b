"""CSV: one row a measurement, or a pair where nothing was measured; images and masks beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.export.csv_stream import csv_rows
from simtip.export.keypoints import MarkedView, marked
from simtip.export.tracer import Tracer
from simtip.geometry import Array
from simtip.image_file import write_png
from simtip.image_sets import BoardImages, NeedleImages, NeedlePair, Reading
from simtip.image_sets.pairs import SIDES
from simtip.render import Backend
from simtip.sensor import Image

Done = Callable[[], None]
Row = dict[str, object]

IMAGES, MASKS = "images", "masks"

AXES, PIXEL = "xyz", "uv"

COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
"""OpenCV's order; scenes have no more."""

_CAMERA = (
    *("width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px"),
    *COEFFICIENTS,
)
_VIEW = (
    *("image", "mask", "true_tip_u_px", "true_tip_v_px", "tip_visible"),
    *("silhouette_tip_u_px", "silhouette_tip_v_px", "axis_u", "axis_v", "mask_area_px"),
    *("detected_tip_u_px", "detected_tip_v_px"),
    *_CAMERA,
)
_POSE = (
    *(f"R_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)),
    *(f"T_{axis}_mm" for axis in AXES),
)
NEEDLE_COLUMNS = (
    *("pair", "source", "label"),
    *(f"{side}_{name}" for side in SIDES for name in _VIEW),
    *_POSE,
    *(f"true_tip_{axis}_mm" for axis in AXES),
    *(f"axis_{axis}" for axis in AXES),
    *("status", "reason", "detector"),
    *(f"measured_tip_{axis}_mm" for axis in AXES),
)
"""Before those of a sweep's factors, which have the names of its table."""

BOARD_COLUMNS = (
    *("pair", "source", "label", "target"),
    *(f"{side}_{name}" for side in SIDES for name in ("image", *_CAMERA)),
    *_POSE,
    *(f"board_R_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)),
    *(f"board_t_{axis}_mm" for axis in AXES),
)
POINT_COLUMNS = (
    *("pair", "side", "point", "u_px", "v_px", "visible"),
    *("board_x_mm", "board_y_mm", "board_z_mm"),
)


def write_needles(
    folder: Path, sets: Sequence[NeedleImages], *, backend: Backend, done: Done
) -> None:
    """Write pairs of images of needles, what is true of them and what was measured on them.

    Parameters
    ----------
    folder
        An empty one.
    sets
        Where the pairs are.
    backend
        What traces masks.
    done
        Called after each pair.

    Raises
    ------
    InputError
        A pair cannot be read.
    """
    settings = dict.fromkeys(name for one in sets for name in one.settings)
    columns = (*NEEDLE_COLUMNS, *(name for name in settings if name not in NEEDLE_COLUMNS))
    tracer = Tracer(backend)
    (folder / MASKS).mkdir()
    with csv_rows(folder / "pairs.csv", columns) as rows:
        for number, pair in enumerate(pair for one in sets for pair in one.pairs()):
            files = write_images(folder, number, pair.images)
            views = marked(pair, tracer)
            true = needle_row(number, pair, files, views)
            for side, view in zip(SIDES, views, strict=True):
                mask = view.surfaces.needle.astype(np.uint8) * np.uint8(255)
                write_png(folder / str(true[f"{side}_mask"]), mask)
            for reading in pair.readings or (None,):
                rows.add(true if reading is None else {**true, **reading_row(reading)})
            done()


def write_boards(folder: Path, sets: Sequence[BoardImages], *, done: Done) -> None:
    """Write pairs of images of calibration boards, and ``points.csv`` with all their points.

    Parameters and errors are those of `write_needles`.
    """
    with ExitStack() as opened:
        rows = opened.enter_context(csv_rows(folder / "pairs.csv", BOARD_COLUMNS))
        points = opened.enter_context(csv_rows(folder / "points.csv", POINT_COLUMNS))
        for number, pair in enumerate(pair for one in sets for pair in one.pairs()):
            files = write_images(folder, number, pair.images)
            row: Row = {"pair": number, "source": pair.source, "label": pair.label}
            row["target"] = str(pair.target)
            for side, name in zip(SIDES, files, strict=True):
                row[f"{side}_image"] = name
            turned = pair.T_wt.R.ravel().tolist()
            row |= dict(zip(BOARD_COLUMNS[-12:-3], turned, strict=True))
            row |= _numbers("board_t_{}_mm", AXES, pair.T_wt.t)
            rows.add(row | _rig(pair.rig))
            for side, places, visible in zip(SIDES, pair.points_px, pair.visible, strict=True):
                for k, (place, seen) in enumerate(zip(places, visible, strict=True)):
                    told: Row = {"pair": number, "side": side, "point": k, "visible": bool(seen)}
                    told |= _numbers("{}_px", PIXEL, place)
                    points.add(told | _numbers("board_{}_mm", AXES, pair.points_mm[k]))
            done()


def write_images(folder: Path, number: int, images: tuple[Image, Image]) -> list[str]:
    """Write both images as they are, and give their names, relative to the folder."""
    (folder / IMAGES).mkdir(exist_ok=True)
    names = [f"{IMAGES}/{number:06d}_{side}.png" for side in SIDES]
    for name, image in zip(names, images, strict=True):
        write_png(folder / name, image)
    return names


def needle_row(
    number: int, pair: NeedlePair, files: Sequence[str], views: Sequence[MarkedView]
) -> Row:
    """Give what is true of a pair."""
    truth = pair.truth
    row: Row = {"pair": number, "source": pair.source, "label": pair.label}
    row |= _numbers("true_tip_{}_mm", AXES, truth.tip_mm)
    row |= _numbers("axis_{}", AXES, truth.axis)
    for side, file, own, view in zip(SIDES, files, (truth.left, truth.right), views, strict=True):
        row |= {
            f"{side}_image": file,
            f"{side}_mask": f"{MASKS}/{number:06d}_{side}.png",
            f"{side}_tip_visible": own.tip_visible and not bool(view.surfaces.obstructed[0]),
            f"{side}_mask_area_px": int(view.surfaces.needle.sum()),
        }
        row |= _numbers(f"{side}_true_tip_{{}}_px", PIXEL, own.tip_px)
        row |= _numbers(f"{side}_silhouette_tip_{{}}_px", PIXEL, own.silhouette_tip_px)
        row |= _numbers(f"{side}_axis_{{}}", PIXEL, own.axis_px)
    return row | _rig(truth.rig)


def reading_row(reading: Reading) -> Row:
    """Give what was measured."""
    row: Row = {
        "status": reading.status,
        "reason": reading.reason,
        "detector": reading.detector,
        **reading.settings,
    }
    if reading.tip_mm is not None:
        row |= _numbers("measured_tip_{}_mm", AXES, reading.tip_mm)
    for side, place in zip(SIDES, reading.tips_px, strict=True):
        if place is not None:
            row |= _numbers(f"{side}_detected_tip_{{}}_px", PIXEL, place)
    return row


def _rig(rig: StereoRig) -> Row:
    """Give both cameras and OpenCV's pose: p_right = R p_left + T."""
    T_rl = rig.T_lr.inverse()
    row: Row = dict(zip(_POSE, [*T_rl.R.ravel().tolist(), *T_rl.t.tolist()], strict=True))
    for side, camera in zip(SIDES, (rig.left, rig.right), strict=True):
        row |= {f"{side}_{name}": value for name, value in _camera(camera)}
    return row


def _camera(camera: Camera) -> Iterator[tuple[str, float]]:
    K = camera.K
    focal, middle = (float(K[0, 0]), float(K[1, 1])), (float(K[0, 2]), float(K[1, 2]))
    padded = (*camera.distortion, *(0.0,) * (len(COEFFICIENTS) - len(camera.distortion)))
    return zip(_CAMERA, (*camera.size, *focal, *middle, *padded), strict=True)


def _numbers(name: str, axes: str, values: Array) -> Row:
    return {name.format(axis): float(v) for axis, v in zip(axes, values, strict=True)}
