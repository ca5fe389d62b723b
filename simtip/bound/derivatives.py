"""How the expected image of one camera changes with the needle's pose and the nuisances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.bound.effort import Effort
from simtip.bound.formation import Picture
from simtip.bound.pose import VIEW_POSE, WIDE, ViewMoves
from simtip.geometry import Array, Pose

if TYPE_CHECKING:
    from simtip.render.moved import BandLight, MovableNeedle, Side

APPEARANCE = ("gain", "offset", "level", "blur")
"""Of each view: factor on the needle's radiance, radiance added to it (W m^-2 sr^-1), factor on
that of all that lies behind, variance of a blur of the whole image (px^2)."""

LAPLACIAN = np.array([[0, 1, 0], [1, -4, 1], [0, 1, 0]], np.float64)

Done = Callable[[int], None]
"""Told the number of samples just taken."""


@dataclass(frozen=True, eq=False)
class Watched:
    """The band of one view, and how it is sampled.

    Attributes
    ----------
    side
        Which camera.
    band
        (n,) flat indices of its pixels.
    effort
        How each of them is sampled.
    replicas
        How many independent estimates.
    picture
        What forms the image.
    """

    side: Side
    band: NDArray[np.uint32]
    effort: Effort
    replicas: int
    picture: Picture


class Derivatives:
    """Derivatives of one view's irradiance, in independent replicas.

    Parameters
    ----------
    needle
        What is moved.
    watched
        Where it is looked at.
    moves
        How the needle moves in this view.
    done
        Told of progress.
    """

    def __init__(
        self, needle: MovableNeedle, watched: Watched, moves: ViewMoves, done: Done
    ) -> None:
        self._needle, self._watched, self._moves, self._done = needle, watched, moves, done
        every = np.arange(len(watched.band))
        at_rest = [self._look(every, Pose.identity(), k) for k in range(watched.replicas)]
        picture = watched.picture
        images = [picture.irradiance(picture.mixed(light.total)) for light in at_rest]
        self.irradiance: Array = np.mean(images, axis=0)
        """(h, w, 3) expected irradiance, W m^-2."""
        self.appearance: Array = np.stack(
            [self._by_appearance(*each) for each in zip(at_rest, images, strict=True)]
        )
        """(R, 4, m, 3) by `APPEARANCE`, at the m pixels that the needle can change."""

    def pose(self, step_px: float) -> Array:
        """Give the derivatives (R, 6, m, 3) by `VIEW_POSE`, from steps that move edges so far."""
        return np.stack(
            [
                np.stack([self._by_pose(name, step_px, k) for name in VIEW_POSE])
                for k in range(self._watched.replicas)
            ]
        )

    def _by_pose(self, name: str, step_px: float, replica: int) -> Array:
        picture, steps = self._watched.picture, self._watched.effort.steps
        step = self._moves.step(name, step_px)
        wide = np.ones_like(steps) if name in WIDE else steps
        change = np.zeros((len(wide), 3))
        for factor in np.unique(wide):
            (some,) = np.nonzero(wide == factor)
            forth, back = (
                picture.mixed(
                    self._look(some, self._moves.moved(name, sign * factor * step), replica).total,
                    some,
                )
                for sign in (1, -1)
            )
            change[some] = (forth - back) / (2 * factor * step)
        # The lens is linear, but takes no light below 0.
        more, less = (picture.irradiance(np.maximum(d, 0), alone=True) for d in (change, -change))
        return self._touched(more - less)

    def _by_appearance(self, light: BandLight, image: Array) -> Array:
        picture = self._watched.picture
        own = picture.irradiance(picture.mixed(light.needle), alone=True)
        covered = np.repeat(light.coverage.astype(np.float64)[:, None], 3, axis=1)
        added = picture.irradiance(covered, alone=True)
        spread = cv2.filter2D(image, -1, LAPLACIAN, borderType=cv2.BORDER_REFLECT) / 2
        return np.stack([self._touched(each) for each in (own, added, image - own, spread)])

    def _look(self, which: NDArray[np.intp], move: Pose, replica: int) -> BandLight:
        watched = self._watched
        samples = watched.effort.samples[which]
        light = self._needle.look(watched.side, watched.band[which], move, samples, replica)
        self._done(int(samples.sum()))
        return light

    def _touched(self, image: Array) -> Array:
        return np.asarray(image[self._watched.picture.touched], np.float32)
