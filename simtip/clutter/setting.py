"""What clutter has to know of the scene around it, and where it may be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.geometry import Array, unit

NEEDLE_CLEAR_MM = 3.0
"""Nothing comes nearer to the needle's surface."""

CAMERA_CLEAR_MM = 40.0
"""Nothing comes nearer to a camera's centre."""

OUT_OF_VIEW_PX = 64.0
"""What is to be out of view is so far from the image's edge, for its blur."""


class Plane(Protocol):
    """The board: point = centre + s x + t y; `simtip.render.board.Board` is one."""

    @property
    def centre(self) -> Array:
        """(3,) mm, world."""

    @property
    def x(self) -> Array:
        """(3,) unit, along s."""

    @property
    def y(self) -> Array:
        """(3,) unit, along t."""

    @property
    def normal(self) -> Array:
        """(3,) unit, towards the cameras."""

    @property
    def half(self) -> Array:
        """(2,) half the sides, mm."""


@dataclass(frozen=True, eq=False)
class LampPlace:
    """Where a lamp is.

    Attributes
    ----------
    centre_mm
        (3,) world.
    half_mm
        (3,) from its centre to its end if it is long; zeros if not.
    """

    centre_mm: Array
    half_mm: Array


@dataclass(frozen=True, eq=False)
class Setting:
    """The scene around the clutter; world frame, mm.

    Attributes
    ----------
    board
        The board.
    rig
        The cameras. Give whole sensors: a region of interest must not move the clutter.
    tip_mm
        (3,) the needle's apex.
    needle_mm
        (n, 3) points along the needle's axis, from the tip to the hub; straight in between.
    needle_radius_mm
        Its largest radius.
    lamps
        What casts shadows.
    """

    board: Plane
    rig: StereoRig
    tip_mm: Array
    needle_mm: Array
    needle_radius_mm: float
    lamps: Sequence[LampPlace] = ()

    @cached_property
    def eyes(self) -> Array:
        """(2, 3) the cameras' centres."""
        return np.stack([np.zeros(3), self.rig.T_lr.t])

    @cached_property
    def box(self) -> tuple[Array, Array] | None:
        """The smallest box (low, high) of the board that holds all that the cameras see of it.

        None where they see nothing of it, or one is behind it. A camera of whose view a part
        misses the board's plane counts as seeing all of the board.
        """
        half = self.board.half
        seen = []
        for camera, axes, eye in self._cameras():
            st = self._meet(eye, camera.rays(_border(camera)) @ axes.T)
            missed = np.isnan(st).any(axis=1)
            if not missed.all():
                seen.append(st[~missed])
                seen += [np.stack([-half, half])] if missed.any() else []
        if not seen or self.heights(self.eyes).min() <= 0:
            return None
        found = np.concatenate(seen)
        low, high = np.maximum(found.min(axis=0), -half), np.minimum(found.max(axis=0), half)
        return (low, high) if (low < high).all() else None

    def heights(self, points: Array) -> Array:
        """Give the distances (...,) of points (..., 3) before the board, mm."""
        found: Array = (points - self.board.centre) @ self.board.normal
        return found

    def at(self, st: Array, height: Array) -> Array:
        """Give the points (..., 3) at heights (...,) on the lines from between the eyes to (s, t).

        So what is placed by its board coordinates is seen about there, however high it hangs.
        """
        foot = self.board.centre + st[..., :1] * self.board.x + st[..., 1:] * self.board.y
        eye = self.eyes.mean(axis=0)
        share = (height / self.heights(eye))[..., None]
        found: Array = foot + share * (eye - foot)
        return found

    def both_see(self, point: Array) -> bool:
        """Say whether a point (3,) falls on both images."""
        return all(
            bool(camera.contains(camera.project((point - eye) @ axes)))
            for camera, axes, eye in self._cameras()
        )

    def below_needle_mm(self) -> float:
        """Give the height up to which nothing touches the needle or comes before it.

        A camera further from the board than the needle sees all that is nearer to it behind the
        needle, or beside.
        """
        nearest = float(self.heights(self.needle_mm).min()) - self.needle_radius_mm
        room = min(nearest, float(self.heights(self.eyes).min()))
        return room - NEEDLE_CLEAR_MM

    def is_free(self, points: Array, radius: float) -> bool:
        """Say whether balls of a radius about points (n, 3) keep clear of the needle and cameras.

        Between neighbours the points may be as far apart as half the clearance.
        """
        starts, ends = self.needle_mm[:-1], self.needle_mm[1:]
        span = ends - starts
        offset = points[:, None] - starts
        along = np.clip((offset * span).sum(-1) / np.maximum((span**2).sum(-1), 1e-12), 0, 1)
        gap = np.linalg.norm(offset - along[..., None] * span, axis=-1).min()
        far = np.linalg.norm(points[:, None] - self.eyes, axis=-1).min()
        spacing = np.linalg.norm(np.diff(points, axis=0), axis=1).max(initial=0.0) / 2
        needle = gap - radius - spacing - self.needle_radius_mm
        return bool(needle >= NEEDLE_CLEAR_MM and far - radius - spacing >= CAMERA_CLEAR_MM)

    def leaves_tip_free(self, points: Array, radius: float, clear_mm: float) -> bool:
        """Say whether balls about points (n, 3) stay away from the tip in both images.

        Parameters
        ----------
        points, radius
            mm.
        clear_mm
            How far, mm at the tip's distance from the camera.
        """
        if clear_mm == 0:
            return True
        for _, axes, eye in self._cameras():
            local = (np.vstack([points, self.tip_mm]) - eye) @ axes
            depth = local[:, 2]
            if depth[-1] <= 0 or (depth[:-1] <= radius).any():
                return False
            # Angles rather than pixels: the same for any lens.
            rays = unit(local)
            gap = np.arccos(np.clip(rays[:-1] @ rays[-1], -1, 1))
            own = np.arcsin(np.clip(radius / np.linalg.norm(local[:-1], axis=1), 0, 1))
            if (gap - own < clear_mm / np.linalg.norm(local[-1])).any():
                return False
        return True

    def is_out_of_view(self, points: Array, radius: float) -> bool:
        """Say whether balls about points (n, 3) are out of both images, and far from the cameras'.

        Straight between neighbours, and closely spaced.
        """
        for camera, axes, eye in self._cameras():
            local = (points - eye) @ axes
            front = local[:, 2] > -radius
            if not front.any():
                continue
            near = np.maximum(local[front, 2], 1.0)
            margin = OUT_OF_VIEW_PX + radius / near * max(camera.K[0, 0], camera.K[1, 1])
            x0, y0, x1, y1 = _limits(camera)
            x, y = (local[front, :2] / near[:, None]).T
            grow_x, grow_y = margin / camera.K[0, 0], margin / camera.K[1, 1]
            inside = (x > x0 - grow_x) & (x < x1 + grow_x) & (y > y0 - grow_y) & (y < y1 + grow_y)
            if inside.any():
                return False
        return True

    def _cameras(self) -> tuple[tuple[Camera, Array, Array], ...]:
        """Give each camera with its axes in the world (columns) and its centre."""
        T = self.rig.T_lr
        return (self.rig.left, np.eye(3), np.zeros(3)), (self.rig.right, T.R, T.t)

    def _meet(self, eye: Array, directions: Array) -> Array:
        """Give (s, t) where rays (n, 3) meet the board's plane; NaN where they do not."""
        board = self.board
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = ((board.centre - eye) @ board.normal) / (directions @ board.normal)
            reach = np.where(reach > 0, reach, np.nan)
            points = eye + reach[:, None] * directions - board.centre
        return np.stack([points @ board.x, points @ board.y], axis=-1)


def _border(camera: Camera) -> Array:
    """Give points (n, 2) px around the image's outer edge."""
    u = np.linspace(-0.5, camera.width - 0.5, 33)
    v = np.linspace(-0.5, camera.height - 0.5, 33)
    sides = [np.stack(np.broadcast_arrays(u, edge), axis=1) for edge in (v[0], v[-1])]
    sides += [np.stack(np.broadcast_arrays(edge, v), axis=1) for edge in (u[0], u[-1])]
    return np.concatenate(sides)


def _limits(camera: Camera) -> tuple[float, float, float, float]:
    """Give x0, y0, x1, y1 of x/z and y/z in the image."""
    xy = camera.normalise(_border(camera))
    (x0, y0), (x1, y1) = np.nanmin(xy, axis=0), np.nanmax(xy, axis=0)
    return float(x0), float(y0), float(x1), float(y1)
