"""The two rays through the detected tips, and the gap between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.camera import StereoRig
from simtip.geometry import Array


@dataclass(frozen=True, eq=False)
class RayPair:
    """Two rays in space, where they are nearest to each other.

    Attributes
    ----------
    centres_mm
        (2, 3) the cameras' centres, left and right, world.
    nearest_mm
        (2, 3) the point of each ray that is nearest to the other.
    """

    centres_mm: Array
    nearest_mm: Array

    @property
    def lines_mm(self) -> Array:
        """Each ray (2, 2, 3) from its centre to where it is nearest to the other."""
        return np.stack([self.centres_mm, self.nearest_mm], axis=1)

    @property
    def gap_mm(self) -> float:
        """How far the rays miss each other."""
        return float(np.linalg.norm(self.nearest_mm[0] - self.nearest_mm[1]))


def ray_pair(rig: StereoRig, left_px: Array, right_px: Array) -> RayPair | None:
    """Give the rays that a rig has for a pair of pixels (2,).

    Returns
    -------
    RayPair or None
        None if they are parallel, or a pixel has no ray.
    """
    directions = np.stack([rig.left.rays(left_px), rig.T_lr.rotate(rig.right.rays(right_px))])
    centres = np.stack([np.zeros(3), rig.T_lr.t])
    # Both depths at once: the gap is square to both rays.
    system = np.stack([directions[0], -directions[1], np.cross(*directions)], axis=1)
    if not np.isfinite(system).all() or abs(np.linalg.det(system)) < np.finfo(np.float64).eps:
        return None
    depths = np.linalg.solve(system, centres[1] - centres[0])[:2]
    return RayPair(centres, centres + depths[:, None] * directions)
