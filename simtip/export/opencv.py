"""OpenCV: pairs of images, rigs, an image list and true points, all for `cv2.FileStorage`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from simtip.camera import StereoRig
from simtip.errors import InputError
from simtip.export.csv_stream import CsvRows
from simtip.export.sources import source_rows
from simtip.geometry import Array
from simtip.image_file import write_png
from simtip.image_sets import BoardImages, BoardPair, NeedleImages, NeedlePair
from simtip.image_sets.pairs import SIDES
from simtip.rig_file import rig_text, write_rig
from simtip.rig_file.opencv_yaml import matrix_lines, storage_text

Done = Callable[[], None]

COMMON = (
    "Row k belongs to pair k. 1 is the left camera, 2 the right. Pixel (0, 0) is the centre of the",
    "top-left pixel; mm in the left camera's frame: x right, y down, z forward.",
)
OF_NEEDLES = (
    "tips1, tips2: true tip in each image, px; also outside of it. tips_mm: true tip. axes: unit",
    "direction from tip to hub. rigs: file of the rig of each pair.",
)
OF_BOARDS = (
    "object_points_mm: points of the board as printed, in its own frame. corners1, corners2: where",
    "they are in each image, px; visible1, visible2: 1 where that is in the image. R by rows, and",
    "t_mm: p_left = R p_board + t. rigs: file of the rig of each pair.",
)


def write_needles(folder: Path, sets: Sequence[NeedleImages], *, done: Done) -> None:
    """Write pairs of images of needles and their true tips.

    Parameters
    ----------
    folder
        An empty one.
    sets
        Where the pairs are.
    done
        Called after each pair.

    Raises
    ------
    InputError
        A pair cannot be read.
    """
    tips1: list[Array] = []
    tips2: list[Array] = []
    places: list[Array] = []
    axes: list[Array] = []
    with source_rows(folder) as sources:
        out = _Pairs(folder, sources)
        for pair in (pair for one in sets for pair in one.pairs()):
            truth = pair.truth
            out.add(pair, truth.rig)
            tips1.append(truth.left.tip_px)
            tips2.append(truth.right.tip_px)
            places.append(truth.tip_mm)
            axes.append(truth.axis)
            done()
        columns = {"tips1": tips1, "tips2": tips2, "tips_mm": places, "axes": axes}
        out.write_truth(OF_NEEDLES, {name: np.stack(rows) for name, rows in columns.items()})


def write_boards(folder: Path, sets: Sequence[BoardImages], *, done: Done) -> None:
    """Write pairs of images of calibration boards and where their points are.

    Parameters and errors are those of `write_needles`; besides, all boards have to be alike.
    """
    pairs: list[BoardPair] = []
    with source_rows(folder) as sources:
        out = _Pairs(folder, sources)
        for pair in (pair for one in sets for pair in one.pairs()):
            if pairs and not np.array_equal(pairs[0].points_mm, pair.points_mm):
                raise InputError(
                    f"shows another board than {pairs[0].source}",
                    file=pair.source,
                    remedy="give folders of different boards one after the other",
                )
            out.add(pair, pair.rig)
            pairs.append(pair)
            done()
        out.write_truth(
            OF_BOARDS,
            {
                "object_points_mm": pairs[0].points_mm,
                "corners1": np.stack([pair.points_px[0] for pair in pairs]),
                "corners2": np.stack([pair.points_px[1] for pair in pairs]),
                "visible1": np.stack([pair.visible[0] for pair in pairs]).astype(np.float64),
                "visible2": np.stack([pair.visible[1] for pair in pairs]).astype(np.float64),
                "R": np.stack([pair.T_wt.R.ravel() for pair in pairs]),
                "t_mm": np.stack([pair.T_wt.t for pair in pairs]),
            },
        )


class _Pairs:
    """Writes images as they come, each rig once, and at the end what lists them."""

    def __init__(self, folder: Path, sources: CsvRows) -> None:
        self._folder, self._sources = folder, sources
        self._names: list[str] = []
        self._rigs: list[str] = []
        self._known: dict[str, str] = {}

    def add(self, pair: NeedlePair | BoardPair, rig: StereoRig) -> None:
        """Write a pair's images, and its rig if it is a new one."""
        names = [f"{side}_{len(self._rigs):06d}.png" for side in SIDES]
        for name, image in zip(names, pair.images, strict=True):
            write_png(self._folder / name, image)
        named = {"source": pair.source, "label": pair.label}
        self._sources.add(dict(zip(SIDES, names, strict=True)) | named)
        self._names += names
        text = rig_text(rig)
        if text not in self._known:
            count = len(self._known) + 1
            self._known[text] = "rig.yaml" if count == 1 else f"rig_{count}.yaml"
            write_rig(self._folder / self._known[text], rig)
        self._rigs.append(self._known[text])

    def write_truth(self, about: Sequence[str], matrices: dict[str, Array]) -> None:
        """Write ``truth.yaml`` and ``image_list.xml``, left and right in turns."""
        lines = ["rigs: [ " + ",\n   ".join(f'"{name}"' for name in self._rigs) + " ]"]
        for name, matrix in matrices.items():
            lines += matrix_lines(name, matrix)
        text = storage_text((*COMMON, *about), lines)
        (self._folder / "truth.yaml").write_text(text, encoding="utf-8")
        listed = "\n".join(self._names)
        text = f'<?xml version="1.0"?>\n<opencv_storage>\n<images>\n{listed}\n</images>\n'
        (self._folder / "image_list.xml").write_text(f"{text}</opencv_storage>\n", encoding="utf-8")
