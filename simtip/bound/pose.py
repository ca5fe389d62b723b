"""The six ways to move a needle: along x, y, z, and turns about its apex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from simtip.geometry import Array, Pose, unit
from simtip.silhouette import projection_jacobian
from simtip.truth import SceneTruth

PLACE = ("x", "y", "z")
"""Of the apex, world, mm."""
TURNS = ("turn_1", "turn_2", "roll")
"""About the apex, radians: about two directions across the axis, and about the axis."""
POSE = (*PLACE, *TURNS)

STEP_PX = 0.02
"""How far in the image a step of the derivatives moves the needle, about."""

AXIS_POINTS = 200


@dataclass(frozen=True, eq=False)
class Axes:
    """Directions (3,), world, unit length, that the needle and the left camera's view of it set.

    Attributes
    ----------
    along
        The needle's axis, from the tip to the hub.
    across
        Square to the axis and to the left camera's line of sight to the apex.
    depth
        Square to both, away from the camera.
    """

    along: Array
    across: Array
    depth: Array

    @classmethod
    def of(cls, truth: SceneTruth) -> Axes:
        """Find them in a scene."""
        along, sight = truth.axis, unit(truth.tip_mm)
        across = unit(np.cross(along, sight))
        return cls(along, across, np.cross(across, along))


@dataclass(frozen=True, eq=False)
class Steps:
    """How far the needle is moved each way: a place's coordinates mm, turns rad."""

    place_mm: float
    tilt: float
    roll: float

    def halved(self) -> Steps:
        """Give steps half as wide."""
        return Steps(self.place_mm / 2, self.tilt / 2, self.roll / 2)

    def of(self, name: str) -> float:
        """Give the step of a parameter."""
        return self.place_mm if name in PLACE else self.roll if name == "roll" else self.tilt


def steps_for(truth: SceneTruth, step_mm: float | None = None) -> Steps:
    """Choose steps that move what is seen of the needle by about `STEP_PX`.

    A power of two: the renderer's poses are in single precision, where it is exact.
    """
    if step_mm is None:
        focal = float(max(truth.rig.left.K[0, 0], truth.rig.left.K[1, 1]))
        step_mm = float(2.0 ** np.round(np.log2(STEP_PX * truth.tip_mm[2] / focal)))
    return Steps(step_mm, step_mm / _lever_mm(truth), step_mm / truth.needle.radius_mm)


def _lever_mm(truth: SceneTruth) -> float:
    """Give half the length of the axis that is in view."""
    along = np.linspace(0, truth.needle.length_mm, AXIS_POINTS)
    points = truth.tip_mm + along[:, None] * truth.axis
    seen = truth.rig.left.contains(truth.rig.left.project(points)) | truth.rig.right.contains(
        truth.rig.right.project(truth.rig.T_lr.inverse().apply(points))
    )
    return float(max(along[seen].max(initial=0.0), truth.needle.diameter_mm)) / 2


def moved(truth: SceneTruth, name: str, amount: float) -> Pose:
    """Give the motion, world, that changes one parameter of the pose by an amount, mm or rad."""
    if name in PLACE:
        return Pose(np.eye(3), amount * np.eye(3)[PLACE.index(name)])
    axes = Axes.of(truth)
    about = {"turn_1": axes.across, "turn_2": axes.depth, "roll": axes.along}[name]
    R = Rotation.from_rotvec(amount * about).as_matrix()
    return Pose(R, truth.tip_mm - R @ truth.tip_mm)


@dataclass(frozen=True, eq=False)
class ViewMoves:
    """How the apex moves in one image when it moves in space.

    Attributes
    ----------
    tip_px, axis_px
        (2,) the apex, and the unit direction of the axis towards the hub.
    by_place
        (2, 3) px along and across the axis, per mm of x, y, z.
    plane
        (3, 3) columns, world: the moves of 1 px along and 1 px across that stay parallel to the
        image plane, mm, and the line of sight, along which the apex's image stays.
    size_px
        Width and height of the image.
    """

    tip_px: Array
    axis_px: Array
    by_place: Array
    plane: Array
    size_px: tuple[int, int]

    @classmethod
    def of(cls, truth: SceneTruth, side: str) -> ViewMoves:
        """Work them out for the left or the right view."""
        view = truth.left if side == "left" else truth.right
        camera = truth.rig.left if side == "left" else truth.rig.right
        T_cw = Pose.identity() if side == "left" else truth.rig.T_lr.inverse()
        apex = T_cw.apply(truth.tip_mm)
        along, across = view.axis_px, np.array([-view.axis_px[1], view.axis_px[0]])
        by_place = np.stack([along, across]) @ projection_jacobian(camera, apex) @ T_cw.R
        in_plane = T_cw.R[:2].T  # the camera's x and y
        sight = T_cw.R.T @ unit(apex)
        plane = np.column_stack([in_plane @ np.linalg.inv(by_place @ in_plane), sight])
        return cls(view.tip_px, view.axis_px, by_place, plane, camera.size)
