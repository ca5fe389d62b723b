"""A pair of images and what is true of it, wherever it comes from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from simtip.camera import StereoRig
from simtip.geometry import Array, Pose
from simtip.sensor import Image
from simtip.spec import SceneSpec
from simtip.target import Target
from simtip.truth import SceneTruth

SIDES = ("left", "right")

Mask = NDArray[np.bool_]
Cell = str | int | float | bool | None


@dataclass(frozen=True, eq=False)
class Reading:
    """What was measured on a pair of images.

    Attributes
    ----------
    detector
        Its name, or its label in a sweep.
    status, reason
        As `simtip.measure.Measurement` has them.
    tips_px
        (2,) where the tip was detected, left and right; None where it was not.
    tip_mm
        (3,) as measured, world; None without one.
    spec
        The scene with what says how it was measured: detection, matching, the rig that measures.
    settings
        What tells a trial from the others of its sweep, by column of its table.
    """

    detector: str
    status: str
    reason: str
    tips_px: tuple[Array | None, Array | None]
    tip_mm: Array | None
    spec: SceneSpec
    settings: Mapping[str, Cell] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class NeedlePair:
    """A pair of images of a needle.

    Attributes
    ----------
    source
        The folder, as it was given.
    label
        What tells the pair from the others of its folder: of a sweep, the first trial of it.
    spec
        The scene; its seed is that of the light.
    truth
        What is true of it.
    images
        Left and right, (H, W, 3) RGB, DN; uint8 at 8 bit, uint16 above.
    readings
        What was measured on them: none, one, or as many as a sweep has trials of them.
    """

    source: str
    label: str
    spec: SceneSpec
    truth: SceneTruth
    images: tuple[Image, Image]
    readings: tuple[Reading, ...] = ()

    @property
    def poses(self) -> tuple[Pose, Pose]:
        """T_cw of both cameras."""
        return Pose.identity(), self.truth.rig.T_lr.inverse()


@dataclass(frozen=True, eq=False)
class BoardPair:
    """A pair of images of a calibration board.

    Attributes
    ----------
    source, label
        The folder, as it was given, and the view's name.
    images
        Left and right, (H, W, 3) RGB, DN; uint8 at 8 bit, uint16 above.
    bit_depth
        Of the sensor.
    rig
        That took them.
    target
        What the board shows.
    points_mm
        (n, 3) where its points really are, board frame.
    outline_mm
        (m, 3) around the printed side, board frame.
    T_wt
        From the board's frame to the world.
    points_px
        (n, 2) where they are in each image, also where that is outside of it.
    visible
        (n,) which lie in each image.
    """

    source: str
    label: str
    images: tuple[Image, Image]
    bit_depth: int
    rig: StereoRig
    target: Target
    points_mm: Array
    outline_mm: Array
    T_wt: Pose
    points_px: tuple[Array, Array]
    visible: tuple[Mask, Mask]


class NeedleImages(Protocol):
    """Pairs of images of needles from one folder.

    Attributes
    ----------
    source
        The folder's name.
    settings
        Columns that `Reading.settings` may have.
    without_images
        How many trials have none, by status.
    """

    source: str
    settings: tuple[str, ...]
    without_images: Mapping[str, int]

    def __len__(self) -> int:
        """Give the number of pairs."""

    def pairs(self) -> Iterator[NeedlePair]:
        """Give them one by one.

        Raises
        ------
        InputError
            One can be neither read nor made.
        """


class BoardImages(Protocol):
    """Pairs of images of calibration boards from one folder, likewise."""

    source: str

    def __len__(self) -> int:
        """Give the number of pairs."""

    def pairs(self) -> Iterator[BoardPair]:
        """Give them one by one; raises InputError."""
