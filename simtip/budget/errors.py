"""What error some causes make together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.budget.apparent import recession
from simtip.budget.causes import Cause
from simtip.budget.observed import Observed, state
from simtip.budget.shares import subsets
from simtip.camera import StereoRig
from simtip.geometry import Array
from simtip.match import match_tips
from simtip.spec import SceneSpec
from simtip.triangulate import triangulate_points

POSITION, STEP, FROM_START = "position", "step", "from_start"

Indices = NDArray[np.intp]

Rigs = Mapping[tuple[bool, bool], Sequence[StereoRig]]
"""That measure, one or one a replicate, by whether calibration and distortion are causes."""


@dataclass(frozen=True, eq=False)
class Truth:
    """What is true of the places.

    Attributes
    ----------
    tips_mm
        (places, 3) world, mm; each place once.
    true_px
        (places, 2, 2) left and right.
    axis
        (3,) unit, from the tip to the hub, world.
    line
        (n,) which of them a run goes through, in its order.
    line_laser_mm
        (replicates, n) what the interferometer reads there.
    steps
        (m, 2) from which to which the steps go that count for accuracy.
    steps_laser_mm
        (replicates, m) how far they are by the interferometer.
    """

    tips_mm: Array
    true_px: Array
    axis: Array
    line: Indices
    line_laser_mm: Array
    steps: Indices
    steps_laser_mm: Array


class Errors:
    """Square errors under any causes.

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
        """Give how far along the needle the tip is seen, (places kept of the run,), mm."""
        focus = state(causes, self._scene, whole_pixels=self._seen.whole_pixels)[0]
        line = self._truth.line
        found: Array = self._apparent[focus][0][line[self.kept[line]]]
        return found

    def squares(self, causes: frozenset[Cause]) -> dict[str, Array]:
        """Give the square errors (replicates, n), mm^2, of what was seen in every state.

        Of positions; of steps (Eq. 3), both ends seen; and of displacements from the run's start,
        none if that was not seen.
        """
        truth, points = self._truth, self._points(causes)
        line, steps, kept = truth.line, truth.steps, self.kept
        on_line, whole = kept[line], kept[steps].all(axis=1)
        from_start = on_line[1:] & on_line[0]
        pairs = np.stack([np.full(len(line) - 1, line[0]), line[1:]], axis=1)
        told_start = np.abs(truth.line_laser_mm[:, 1:] - truth.line_laser_mm[:, :1])
        told_steps = truth.steps_laser_mm
        if Cause.REFERENCE not in causes:
            told_start, told_steps = self._moved(pairs)[None], self._moved(steps)[None]
        off = ((points - truth.tips_mm) ** 2).sum(axis=-1)
        return {
            POSITION: off[:, line[on_line]],
            STEP: ((_lengths(points, steps) - told_steps) ** 2)[:, whole],
            FROM_START: ((_lengths(points, pairs) - told_start) ** 2)[:, from_start],
        }

    def refused(self, causes: frozenset[Cause]) -> float:
        """Give the share of a run's measurements, with those causes, that matching would refuse."""
        whole = self._seen.whole_pixels
        tips = self._drawn(self._seen.tips_px[state(causes, self._scene, whole_pixels=whole)])
        rigs = self._rigs[Cause.CALIBRATION in causes, Cause.DISTORTION in causes]
        line = self._truth.line[self.kept[self._truth.line]]
        limit = self._scene.match.max_distance_px
        refused = [
            not match_tips(
                tips[draw, place, 0],
                tips[draw, place, 1],
                rigs[draw % len(rigs)],
                max_distance_px=limit,
            ).ok
            for draw in range(self._replicates)
            for place in line
        ]
        return float(np.mean(refused)) if refused else 0.0

    def _moved(self, pairs: Indices) -> Array:
        """Give how far the needle really went, (pairs,), mm."""
        return _lengths(self._truth.tips_mm, pairs)

    def all(self, causes: Sequence[Cause]) -> dict[str, dict[frozenset[int], Array]]:
        """Give the square errors under every subset of causes, by kind and by subset."""
        found: dict[str, dict[frozenset[int], Array]] = {POSITION: {}, STEP: {}, FROM_START: {}}
        for subset in subsets(len(causes)):
            squares = self.squares(frozenset(causes[k] for k in subset))
            for kind, values in squares.items():
                found[kind][subset] = values
        return found

    def _points(self, causes: frozenset[Cause]) -> Array:
        """Triangulate (replicates, places, 3), mm."""
        whole = self._seen.whole_pixels
        now = state(causes, self._scene, whole_pixels=whole)
        tips = self._filled(self._seen.tips_px[now])
        _, common, own = self._apparent[now[0]]
        if Cause.RECESSION not in causes:
            tips = tips - common
        if Cause.MISMATCH not in causes:
            tips = tips - own
        tips = self._drawn(tips)
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

    def _drawn(self, tips: Array) -> Array:
        return np.broadcast_to(tips, (self._replicates, *tips.shape[1:]))

    def _filled(self, tips: Array) -> Array:
        """Put the true tip where none was seen, which then does not count."""
        return np.where(self.kept[:, None, None], tips, self._truth.true_px)

    def _focuses(self) -> set[bool]:
        return {focus for focus, *_ in self._seen.tips_px}

    def _seen_everywhere(self) -> Array:
        found = [np.isfinite(tips).all(axis=(0, 2, 3)) for tips in self._seen.tips_px.values()]
        kept: Array = np.logical_and.reduce(found)
        return kept

    def _split(self, focus: bool) -> tuple[Array, Array, Array]:
        calm = self._filled(self._seen.tips_px[focus, False, False, not self._seen.whole_pixels])
        truth = self._truth
        rig = self._scene.rig.rig()
        return recession(calm[0], truth.true_px, truth.tips_mm, truth.axis, rig)


def _lengths(points_mm: Array, pairs: Indices) -> Array:
    """Give the distances (..., pairs) from one place to the other, mm."""
    ends = points_mm[..., pairs, :]
    lengths: Array = np.linalg.norm(ends[..., 1, :] - ends[..., 0, :], axis=-1)
    return lengths
