"""The Cramer-Rao bound of one scene, as numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from simtip.bound.derivatives import APPEARANCE
from simtip.bound.information import Information
from simtip.bound.maps import InformationMap
from simtip.bound.pose import PLACE, Axes, ViewMoves
from simtip.geometry import Array

SIDES = ("left", "right")

NUISANCES: dict[str, tuple[str, ...]] = {
    "axis": ("turn_1", "turn_2"),
    "roll": ("roll",),
    "contrast": tuple(f"{side}_{name}" for side in SIDES for name in APPEARANCE[:3]),
    "blur": tuple(f"{side}_blur" for side in SIDES),
}
"""What may be unknown beside the tip's place, and its parameters."""

FLAT = ("along_px", "across_px", "sight_mm")
"""Moves of the apex that one camera tells apart: two parallel to its image plane, one that it
hardly sees."""


@dataclass(frozen=True, eq=False)
class ViewBound:
    """What one view tells.

    Attributes
    ----------
    information
        About the pose and this view's appearance; of nothing if the needle is not in view.
    moves
        How the apex moves in its image.
    map
        Where it sits; None if the needle is not in view.
    """

    information: Information
    moves: ViewMoves
    map: InformationMap | None

    def deviations_px(self) -> Array:
        """Give the bound along and across (2,), px, all nuisances free."""
        moves = [dict(zip(PLACE, row, strict=True)) for row in self.moves.by_place.tolist()]
        return self.information.deviations(moves)

    def known_deviations_px(self) -> Array:
        """Give the same with all but the two moves parallel to the image plane known."""
        known = self.information.of(PLACE).transformed(FLAT, self.moves.plane).of(FLAT[:2])
        return known.deviations([{name: 1.0} for name in FLAT[:2]])


@dataclass(frozen=True, eq=False)
class TipBound:
    """The least standard deviations that unbiased measurements of a scene's tip can have.

    Attributes
    ----------
    scene, seed, backend
        What was looked at, and how.
    step_mm, samples, replicas
        Step of the derivatives; samples of a pixel at the needle's edge, all replicas together.
    views
        Left and right.
    axes
        Directions along and across the needle.
    convergence
        Ratios of the norm with nuisances free to that with half the step, and with half the
        samples, to the norm itself; `noise_share`: Monte-Carlo noise over information, for x, y, z.
    timings_s
        Wall time.
    """

    scene: str
    seed: int
    backend: str
    step_mm: float
    samples: int
    replicas: int
    views: dict[str, ViewBound]
    axes: Axes
    convergence: dict[str, Any] = field(default_factory=dict)
    timings_s: dict[str, float] = field(default_factory=dict)

    @property
    def information(self) -> Information:
        """What both views together tell."""
        return self.views["left"].information + self.views["right"].information

    def deviations_mm(
        self, directions: Sequence[Array], free: Sequence[str] = tuple(NUISANCES)
    ) -> Array:
        """Give the bound (k,) of the tip's place in k directions, mm.

        Parameters
        ----------
        directions
            (3,) each, world.
        free
            Which of `NUISANCES` are unknown.
        """
        every = self.information
        asked = [*PLACE, *(name for kind in free for name in NUISANCES[kind])]
        unknown = [name for name in asked if name in every.names]  # of views that see the needle
        combinations = [dict(zip(PLACE, map(float, d), strict=True)) for d in directions]
        return every.of(unknown).deviations(combinations)

    def place_mm(self, free: Sequence[str] = tuple(NUISANCES)) -> dict[str, float]:
        """Give x, y, z and their norm, mm; inf where the images do not determine it."""
        found = self.deviations_mm(list(np.eye(3)), free)
        return {**dict(zip(PLACE, found.tolist(), strict=True)), "norm": float(np.hypot.reduce(found))}

    def axis_mm(self, free: Sequence[str] = tuple(NUISANCES)) -> dict[str, float]:
        """Give the bound along the axis, across it, and in depth, mm."""
        axes = self.axes
        found = self.deviations_mm([axes.along, axes.across, axes.depth], free)
        return dict(zip(("along", "across", "depth"), found.tolist(), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers and texts; null where the images do not determine a quantity."""
        px = {side: view.deviations_px() for side, view in self.views.items()}
        known_px = {side: view.known_deviations_px() for side, view in self.views.items()}
        return _finite(
            {
                "scene": self.scene,
                "seed": self.seed,
                "backend": self.backend,
                "bound_mm": self.place_mm(),
                "bound_known_mm": self.place_mm(()),
                "bound_axis_mm": self.axis_mm(),
                "bound_axis_known_mm": self.axis_mm(()),
                "bound_px": {side: _along_across(found) for side, found in px.items()},
                "bound_known_px": {side: _along_across(found) for side, found in known_px.items()},
                "nuisances": list(NUISANCES),
                "without_effect": list(self.information.silent()),
                "step_mm": self.step_mm,
                "samples": self.samples,
                "replicas": self.replicas,
                "convergence": self.convergence,
                "timings_s": self.timings_s,
            }
        )


def efficiency(bound: float | None, rmse: float | None) -> float | None:
    """Give bound / RMSE: 1 is as good as unbiased measurement can be; bias counts against it.

    Parameters
    ----------
    bound, rmse
        In the same unit; None where there is none.

    Returns
    -------
    efficiency
        None where one is unknown or not finite, or the RMSE is 0.
    """
    if bound is None or rmse is None or not (np.isfinite(bound) and np.isfinite(rmse)):
        return None
    return float(bound / rmse) if rmse > 0 else None


def _along_across(found: Array) -> dict[str, float]:
    return {"along": float(found[0]), "across": float(found[1])}


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(each) for key, each in value.items()}
    return None if isinstance(value, float) and not np.isfinite(value) else value
