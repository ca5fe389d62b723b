"""The Cramer-Rao bound of one scene, as numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from simtip.bound.derivatives import APPEARANCE
from simtip.bound.information import Information
from simtip.bound.maps import InformationMap
from simtip.bound.pose import PLACE, POSE, VIEW_PLACE, Axes, ViewMoves
from simtip.geometry import Array
from simtip.noise_budget import SIDES, Side

NUISANCES: dict[str, tuple[str, ...]] = {
    "axis": ("turn_1", "turn_2"),
    "roll": ("roll",),
    "contrast": tuple(f"{side}_{name}" for side in SIDES for name in APPEARANCE[:3]),
    "blur": tuple(f"{side}_blur" for side in SIDES),
}
"""What may be unknown beside the tip's place, and its parameters."""


@dataclass(frozen=True, eq=False)
class ViewBound:
    """What one view tells.

    Attributes
    ----------
    information
        About `VIEW_POSE` and this view's appearance; none if the needle is not in view.
    moves
        How the apex moves in its image.
    map
        Where it sits; None if the needle is not in view.
    """

    information: Information
    moves: ViewMoves
    map: InformationMap | None

    def in_world(self) -> Information:
        """Give it about the pose as the world counts it, `POSE`."""
        names = self.information.names
        basis = np.eye(len(names))
        basis[: len(POSE), : len(POSE)] = self.moves.from_world
        return self.information.transformed((*POSE, *names[len(POSE) :]), basis)

    def deviations_px(self) -> Array:
        """Give the bound of the apex's image along and across (2,), px, all else unknown."""
        return self.information.deviations([{name: 1.0} for name in VIEW_PLACE[:2]])

    def known_deviations_px(self) -> Array:
        """Give the same for moves parallel to the image plane, with all else known."""
        names = VIEW_PLACE[:2]
        known = self.information.of(VIEW_PLACE).transformed(names, self.moves.parallel)
        return known.deviations([{name: 1.0} for name in names])


@dataclass(frozen=True, eq=False)
class TipBound:
    """The least standard deviations that unbiased measurements of a scene's tip can have.

    Attributes
    ----------
    scene, seed, backend
        What was looked at, and how.
    inputs_sha256
        Digests of all parts of the scene that the bound depends on: `simtip.bound.bound_digests`.
    step_px, step_mm, samples, replicas
        Step of the derivatives in the left image and at the apex; samples of a pixel at the
        needle's edge, all replicas together; in how many.
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
    inputs_sha256: dict[str, str]
    step_px: float
    step_mm: float
    samples: int
    replicas: int
    views: dict[Side, ViewBound]
    axes: Axes
    convergence: dict[str, Any] = field(default_factory=dict)
    timings_s: dict[str, float] = field(default_factory=dict)

    @property
    def information(self) -> Information:
        """What both views together tell."""
        return self.views["left"].in_world() + self.views["right"].in_world()

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
        norm = float(np.hypot.reduce(found))
        return {**dict(zip(PLACE, found.tolist(), strict=True)), "norm": norm}

    def axis_mm(self, free: Sequence[str] = tuple(NUISANCES)) -> dict[str, float]:
        """Give the bound along the axis, across it, and in depth, mm."""
        axes = self.axes
        found = self.deviations_mm([axes.along, axes.across, axes.depth], free)
        return dict(zip(("along", "across", "depth"), found.tolist(), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers and texts; null where the images do not determine a quantity."""
        px = {side: view.deviations_px() for side, view in self.views.items()}
        known_px = {side: view.known_deviations_px() for side, view in self.views.items()}
        return _finite_only(
            {
                "scene": self.scene,
                "seed": self.seed,
                "backend": self.backend,
                "inputs_sha256": self.inputs_sha256,
                "bound_mm": self.place_mm(),
                "bound_known_mm": self.place_mm(()),
                "bound_axis_mm": self.axis_mm(),
                "bound_axis_known_mm": self.axis_mm(()),
                "bound_px": {side: _along_across(found) for side, found in px.items()},
                "bound_known_px": {side: _along_across(found) for side, found in known_px.items()},
                "nuisances": list(NUISANCES),
                "without_effect": list(self.information.silent()),
                "step_px": self.step_px,
                "step_mm": self.step_mm,
                "samples": self.samples,
                "replicas": self.replicas,
                "convergence": self.convergence,
                "timings_s": self.timings_s,
            }
        )


def _along_across(found: Array) -> dict[str, float]:
    return {"along": float(found[0]), "across": float(found[1])}


def _finite_only(data: dict[str, Any]) -> dict[str, Any]:
    """Put None for numbers that are not finite."""
    found: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict):
            found[key] = _finite_only(value)
        else:
            found[key] = None if isinstance(value, float) and not np.isfinite(value) else value
    return found
