"""What error some causes make together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from simtip.budget.apparent import recession
from simtip.budget.causes import Cause
from simtip.budget.observed import Observed, state
from simtip.budget.shares import subsets
from simtip.camera import StereoRig
from simtip.geometry import Array
from simtip.spec import SceneSpec
from simtip.triangulate import triangulate_points

POSITION, STEP, FROM_START = "position", "step", "from_start"

Rigs = Mapping[tuple[bool, bool], Sequence[StereoRig]]
"""That measure, one or one a replicate, by whether calibration and distortion are causes."""


@dataclass(frozen=True, eq=False)
class Truth:
    """What is true of the places.

    Attributes
    ----------
    tips_mm
        (places, 3) world, mm.
    true_px
        (places, 2, 2) left and right.
    axis
        (3,) unit, from the tip to the hub, world.
    laser_mm
        (replicates, places) what the interferometer reads.
    """

    tips_mm: Array
    true_px: Array
    axis: Array
    laser_mm: Array


class Errors:
    """Mean square errors under any causes.

    Parameters
    ----------
    scene
        The scene.
    truth, observed, rigs
        What is true, what was seen, and what measures.
    replicates
        Draws of noise, calibration and reference.
    """

    def __init__(
        self, scene: SceneSpec, truth: Truth, observed: Observed, rigs: Rigs, replicates: int
    ) -> None:
        self._scene, self._truth, self._seen, self._rigs = scene, truth, observed, rigs
        self._replicates = replicates
        self.kept = self._seen_everywhere()
        """(places,) which of them were seen in every state and draw: others do not count."""
        self._apparent = {focus: self._split(focus) for focus in self._focuses()}

    def recession_mm(self, causes: frozenset[Cause]) -> Array:
        """Give how far along the needle the tip is seen, (places kept,), mm."""
        focus = state(causes, self._scene, whole_pixels=self._seen.whole_pixels)[0]
        return self._apparent[focus][0]

    def mean_squares(self, causes: frozenset[Cause]) -> dict[str, Array]:
        """Give the mean square errors (replicates,), mm^2.

        Of positions, of steps (Eq. 3), and of displacements from the first place.
        """
        points = self._points(causes)
        true, laser = self._truth.tips_mm[self.kept], self._truth.laser_mm[:, self.kept]
        asked = Cause.REFERENCE in causes
        moved = [
            np.linalg.norm(points[:, 1:] - points[:, :-1], axis=-1),
            np.linalg.norm(points[:, 1:] - points[:, :1], axis=-1),
        ]
        if asked:
            told = [np.abs(np.diff(laser, axis=1)), np.abs(laser[:, 1:] - laser[:, :1])]
        else:
            told = [
                np.linalg.norm(np.diff(true, axis=0), axis=-1)[None],
                np.linalg.norm(true[1:] - true[:1], axis=-1)[None],
            ]
        return {
            POSITION: ((points - true) ** 2).sum(axis=-1).mean(axis=-1),
            STEP: ((moved[0] - told[0]) ** 2).mean(axis=-1),
            FROM_START: ((moved[1] - told[1]) ** 2).mean(axis=-1),
        }

    def all(self, causes: Sequence[Cause]) -> dict[str, dict[frozenset[int], Array]]:
        """Give the mean square errors under every subset of causes, by kind and by subset."""
        found: dict[str, dict[frozenset[int], Array]] = {POSITION: {}, STEP: {}, FROM_START: {}}
        for subset in subsets(len(causes)):
            squares = self.mean_squares(frozenset(causes[k] for k in subset))
            for kind, values in squares.items():
                found[kind][subset] = values
        return found

    def _points(self, causes: frozenset[Cause]) -> Array:
        """Triangulate (replicates, places, 3), mm."""
        whole = self._seen.whole_pixels
        now = state(causes, self._scene, whole_pixels=whole)
        tips = self._seen.tips_px[now][:, self.kept]
        _, common, own = self._apparent[now[0]]
        if Cause.RECESSION not in causes:
            tips = tips - common
        if Cause.MISMATCH not in causes:
            tips = tips - own
        tips = np.broadcast_to(tips, (self._replicates, *tips.shape[1:]))
        rigs = self._rigs[Cause.CALIBRATION in causes, Cause.DISTORTION in causes]
        method = self._scene.triangulate.method
        if len(rigs) == 1:
            return triangulate_points(tips[:, :, 0], tips[:, :, 1], rigs[0], method)
        return np.stack(
            [
                triangulate_points(tip[:, 0], tip[:, 1], rig, method)
                for tip, rig in zip(tips, rigs, strict=True)
            ]
        )

    def _focuses(self) -> set[bool]:
        return {focus for focus, _, _ in self._seen.tips_px}

    def _seen_everywhere(self) -> Array:
        found = [np.isfinite(tips).all(axis=(0, 2, 3)) for tips in self._seen.tips_px.values()]
        kept: Array = np.logical_and.reduce(found)
        return kept

    def _split(self, focus: bool) -> tuple[Array, Array, Array]:
        calm = self._seen.tips_px[focus, False, not self._seen.whole_pixels][0]
        truth, kept = self._truth, self.kept
        return recession(
            calm[kept],
            truth.true_px[kept],
            truth.tips_mm[kept],
            truth.axis,
            self._scene.rig.rig(),
        )
