"""The needle moved a little and looked at again, with the same sample points: for derivatives.

Differences of two renders with common random numbers are far less noisy than the renders. Only the
band of pixels that the needle may touch is sampled. The light on the background stays that of the
needle where the scene has it: its shadow does not move along.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Pose
from simtip.render.backend import Backend
from simtip.render.chunks import aligned, batches, means
from simtip.render.engine import dr, mi
from simtip.render.look import EDGE_MARGIN_PX
from simtip.render.needle_subject import NeedleSubject
from simtip.render.pair import Stage, paint, set_stage
from simtip.render.progress import Tally
from simtip.render.sobol import Points, points_of
from simtip.render.transport import radiance
from simtip.render.view import Floats, View
from simtip.seeding import seed32
from simtip.spec import SceneSpec

Side = Literal["left", "right"]
Pixels = NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class BandLight:
    """Light of n pixels, per unit radiance of each light group.

    Attributes
    ----------
    total
        (n, groups, 3) float32, all that reaches the pixel; channels r g b, the ambient group last.
    needle
        (n, groups, 3) float32, the part of it that comes off the needle.
    coverage
        (n,) float32, the part of the pixel that the needle covers.
    """

    total: Floats
    needle: Floats
    coverage: Floats


class MovableNeedle:
    """A scene that is loaded and lit, whose needle can be moved.

    `simtip.render.movable_needle` makes it.

    Attributes
    ----------
    views
        Left and right as they are with the needle where the scene has it.
    """

    def __init__(
        self,
        spec: SceneSpec,
        subject: NeedleSubject,
        stage: Stage,
        views: tuple[View, View],
        seed: int,
    ) -> None:
        self.views = views
        self._subject, self._stage, self._seed = subject, stage, seed
        rig = spec.rig.rig()
        self._T_cw = {"left": Pose.identity(), "right": rig.T_lr.inverse()}
        self._looks = dict(zip(("left", "right"), stage.looks, strict=True))

    def band(self, side: Side) -> Pixels:
        """Give the pixels (n,), flat indices, that the needle or its blur may touch."""
        look = self._looks[side]
        margin = look.reach_px + 2 * EDGE_MARGIN_PX
        mask = self._subject.footprint(self._T_cw[side], look.camera, margin)
        return np.flatnonzero(mask).astype(np.uint32)

    def look(
        self,
        side: Side,
        pixels: Pixels,
        move: Pose,
        samples: NDArray[np.int64],
        replica: int = 0,
    ) -> BandLight:
        """Sample pixels with the needle moved.

        Parameters
        ----------
        side
            Which camera.
        pixels
            (n,) flat indices.
        move
            From where a point of the needle is in the scene to where it is now, world, mm.
        samples
            (n,) of each pixel; not many different numbers.
        replica
            Which of the independent sets of sample points: the same one for the same points.
        """
        world, backdrop = self._stage.world, self._stage.backdrop
        eye = self._looks[side].eye
        self._subject.move(world.scene, move)

        def trace(pixel: Any, points: Points) -> list[Any]:
            shares, needle, _ = radiance(world, backdrop, eye.sample_rays(pixel, points), points)
            channels = [channel for share in shares for channel in share]
            return [*channels, *(needle * channel for channel in channels), needle]

        seed = seed32(self._seed, side, "moved", replica)
        groups = backdrop.groups
        every = np.zeros((len(pixels), 6 * groups + 1), np.float32)
        for each in np.unique(samples):
            (chosen,) = np.nonzero(samples == each)
            for part in batches(chosen, int(each)):
                numbers = aligned(pixels[part])
                points, index = points_of(numbers, int(each), seed)
                pixel = dr.gather(mi.UInt32, mi.UInt32(numbers), index)
                every[part] = means(trace(pixel, points), int(each))
        shape = len(pixels), groups, 3
        return BandLight(
            every[:, : 3 * groups].reshape(shape),
            every[:, 3 * groups : -1].reshape(shape),
            every[:, -1],
        )


def set_movable(spec: SceneSpec, backend: Backend, seed: int) -> MovableNeedle:
    """Load, light and render a scene; see `simtip.render.movable_needle`."""
    tally = Tally(None)
    subject = NeedleSubject(spec)
    stage = set_stage(spec, seed, None, tally, subject)
    views = paint(spec, stage, backend, seed, None, tally)
    return MovableNeedle(spec, subject, stage, views, seed)
