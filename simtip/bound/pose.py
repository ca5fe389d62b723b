"""The six ways to move a needle, as the world counts them and as one camera sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from simtip.camera import Camera
from simtip.geometry import Array, Pose, unit
from simtip.silhouette import projection_jacobian
from simtip.truth import SceneTruth

PLACE = ("x", "y", "z")
"""Of the apex, world, mm."""
TURNS = ("turn_1", "turn_2", "roll")
"""About the apex, radians: about the left camera's `Axes.across` and `Axes.depth`, and the axis."""
POSE = (*PLACE, *TURNS)

VIEW_PLACE = ("along_px", "across_px", "sight_mm")
"""Moves of the apex as one camera sees them: along the needle's axis and across it, by so much of
its image, and along the line of sight."""
VIEW_POSE = (*VIEW_PLACE, "tilt", "turn", "roll")
"""And turns about the apex, radians: out of the image, in it, and about the axis."""

STEP_PX = 0.02
"""How far a step of the derivatives moves the needle's edges in the image, about."""

MOST_TILT = 0.005
"""Radians; a tilt hardly moves edges, but highlights."""

ALONG_STEPS = 4.0
"""Along the axis a tapering tip's edges move by a fraction of the step, and the noise of their
samples would be that much louder: its step is so many times as long. (On scenes/01 this takes the
bound's scatter between seeds from 4 % to below 1 %.)"""

WIDE = ("sight_mm", "tilt")
"""What hardly moves edges: its steps are large anyhow."""

AXIS_POINTS = 200


@dataclass(frozen=True, eq=False)
class Axes:
    """Directions (3,), world, unit length, that the needle and a line of sight to its apex set.

    Attributes
    ----------
    along
        The needle's axis, from the tip to the hub.
    across
        Square to the axis and to the line of sight.
    depth
        Square to both, away from the camera.
    """

    along: Array
    across: Array
    depth: Array

    @classmethod
    def of(cls, axis: Array, sight: Array) -> Axes:
        """Find them for an axis and a line of sight, world, not parallel."""
        across = unit(np.cross(axis, sight))
        return cls(axis, across, np.cross(across, axis))

    def matrix(self) -> Array:
        """Give across, depth, along as columns (3, 3): what tilt, turn and roll are about."""
        return np.column_stack([self.across, self.depth, self.along])


@dataclass(frozen=True, eq=False)
class ViewMoves:
    """How the needle moves in one image when it moves in space.

    Attributes
    ----------
    tip_px, axis_px
        (2,) the apex, and the unit direction of the axis towards the hub.
    size_px
        Width and height of the image.
    by_place
        (2, 3) px along and across the axis, per mm of x, y, z.
    place
        (3, 3) columns, world, mm: the moves `VIEW_PLACE`.
    parallel
        (3, 2) coefficients of `VIEW_PLACE` that move the apex's image 1 px along and 1 px across
        the axis, parallel to the image plane.
    axes
        Of this camera's line of sight.
    tip_mm
        (3,) the apex, world.
    from_world
        (6, 6): `VIEW_POSE` = from_world @ `POSE`, to first order.
    radius_mm, lever_mm, distance_mm
        The needle's radius, half the length of axis in view, and the apex's distance.
    """

    tip_px: Array
    axis_px: Array
    size_px: tuple[int, int]
    by_place: Array
    place: Array
    parallel: Array
    axes: Axes
    tip_mm: Array
    from_world: Array
    radius_mm: float
    lever_mm: float
    distance_mm: float

    @classmethod
    def of(cls, truth: SceneTruth, side: str) -> ViewMoves:
        """Work them out for the left or the right view."""
        view = truth.left if side == "left" else truth.right
        camera = truth.rig.left if side == "left" else truth.rig.right
        T_cw = Pose.identity() if side == "left" else truth.rig.T_lr.inverse()
        apex = T_cw.apply(truth.tip_mm)
        along, across = view.axis_px, np.array([-view.axis_px[1], view.axis_px[0]])
        by_place = np.stack([along, across]) @ projection_jacobian(camera, apex) @ T_cw.R
        sight = T_cw.R.T @ unit(apex)
        in_plane = T_cw.R[:2].T  # the camera's x and y
        parallel = in_plane @ np.linalg.inv(by_place @ in_plane)
        # Moved along itself, a shaft stays what it is: that derivative has no noise there.
        place = np.column_stack([truth.axis / (by_place[0] @ truth.axis), parallel[:, 1], sight])
        axes = Axes.of(truth.axis, sight)
        world = Axes.of(truth.axis, unit(truth.tip_mm))
        from_world = np.zeros((6, 6))
        from_world[:3, :3] = np.linalg.inv(place)
        from_world[3:, 3:] = axes.matrix().T @ world.matrix()
        return cls(
            tip_px=view.tip_px,
            axis_px=view.axis_px,
            size_px=camera.size,
            by_place=by_place,
            place=place,
            parallel=np.linalg.solve(place, parallel),
            axes=axes,
            tip_mm=truth.tip_mm,
            from_world=from_world,
            radius_mm=truth.needle.radius_mm,
            lever_mm=_lever_mm(truth, camera, T_cw),
            distance_mm=float(np.linalg.norm(apex)),
        )

    def step(self, name: str, step_px: float) -> float:
        """Give the step of one of `VIEW_POSE` that moves edges by about `step_px`; px, mm, rad."""
        if name in ("along_px", "across_px"):
            return step_px * (ALONG_STEPS if name == "along_px" else 1.0)
        step_mm = self.step_mm(step_px)
        # Along the line of sight only the width changes.
        nearer_mm = step_mm * self.distance_mm / self.radius_mm
        return {
            "sight_mm": nearer_mm,
            "tilt": min(nearer_mm / self.lever_mm, MOST_TILT),
            "turn": step_mm / self.lever_mm,
            "roll": step_mm / self.radius_mm,
        }[name]

    def step_mm(self, step_px: float) -> float:
        """Give how far in space, at the apex, so many pixels across the axis are, mm."""
        return step_px * float(np.linalg.norm(self.place[:, 1]))

    def moved(self, name: str, amount: float) -> Pose:
        """Give the motion, world, that changes one of `VIEW_POSE` by an amount; px, mm, rad."""
        if name in VIEW_PLACE:
            return Pose(np.eye(3), amount * self.place[:, VIEW_PLACE.index(name)])
        about = {"tilt": self.axes.across, "turn": self.axes.depth, "roll": self.axes.along}[name]
        R = scipy.spatial.transform.Rotation.from_rotvec(amount * about).as_matrix()
        return Pose(R, self.tip_mm - R @ self.tip_mm)


def _lever_mm(truth: SceneTruth, camera: Camera, T_cw: Pose) -> float:
    """Give half the length of the axis that is in view, one diameter at least."""
    along = np.linspace(0, truth.needle.length_mm, AXIS_POINTS)
    points = T_cw.apply(truth.tip_mm + along[:, None] * truth.axis)
    seen = camera.contains(camera.project(points))
    return max(float(along[seen].max(initial=0.0)) / 2, truth.needle.diameter_mm)
