"""Where the cameras are to each other, before the joint adjustment.

Each camera alone has put every board somewhere; a view seen by both thus gives a relative pose of
its own. The one that the views agree on best is the start: its median misfit over the views is the
least, so up to half of them may be wrong. The views are also asked in which of the target's
symmetric numberings they agree, since a plain chessboard looks the same after half a turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array, Pose

DISAGREE_MEDIANS = 6.0
"""A view disagrees if its board is off by more than this many times the median,"""

AT_LEAST_RAD, AT_MOST_RAD = 0.01, 0.03
"""but never below the first of these angles as the camera sees it, and always above the second."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """What the views say about the relative pose.

    Attributes
    ----------
    T_lr
        Right camera to left camera coordinates, mm.
    numbering
        (views,) which numbering of the right sighting fits best, an index into those given.
    off_px
        (views,) how far off the right camera the board then is, px.
    off_mm
        (views,) the same at the board, mm.
    limit_px
        Beyond it a view disagrees.
    """

    T_lr: Pose
    numbering: NDArray[np.intp]
    off_px: Array
    off_mm: Array
    limit_px: float

    @property
    def agrees(self) -> NDArray[np.bool_]:
        """(views,) whether each view agrees."""
        within: NDArray[np.bool_] = self.off_px <= self.limit_px
        return within


def agree(
    left: tuple[Array, Array],
    right: tuple[Array, Array],
    far_mm: Array,
    numbered_mm: Array,
    focal_px: float,
) -> Agreement:
    """Find the relative pose that most views agree on.

    Parameters
    ----------
    left, right
        Rotations (n, 3, 3) and translations (n, 3), mm, of the board in each camera, of the views
        seen by both.
    far_mm
        (c, 3) a few points of the target, far apart.
    numbered_mm
        (k, c, 3) where on the target the right camera took these points to be, for each way of
        numbering; the first is `far_mm` itself.
    focal_px
        Of the right camera.
    """
    in_left = np.einsum("nij,cj->nci", left[0], far_mm) + left[1][:, None]
    in_right = np.einsum("nij,kcj->knci", right[0], numbered_mm) + right[1][:, None]
    to_px = focal_px / np.abs(in_right[..., 2]).mean(axis=2)
    poses = [
        _aligned(P_l, P_r) for of_one in in_right for P_l, P_r in zip(in_left, of_one, strict=True)
    ]
    off_mm = [np.linalg.norm(in_right - (in_left - T) @ R, axis=3).max(axis=2) for R, T in poses]
    medians = [float(np.median((off * to_px).min(axis=0))) for off in off_mm]
    best = int(np.argmin(medians))
    choice, views = np.argmin(off_mm[best] * to_px, axis=0), np.arange(len(in_left))
    return Agreement(
        T_lr=Pose(*poses[best]),
        numbering=choice.astype(np.intp),
        off_px=(off_mm[best] * to_px)[choice, views],
        off_mm=off_mm[best][choice, views],
        limit_px=float(
            np.clip(
                DISAGREE_MEDIANS * medians[best], AT_LEAST_RAD * focal_px, AT_MOST_RAD * focal_px
            )
        ),
    )


def _aligned(to: Array, points: Array) -> tuple[Array, Array]:
    """Give R, T of least squares with ``to = R points + T`` (Kabsch)."""
    a, b = to.mean(axis=0), points.mean(axis=0)
    u, _, vt = np.linalg.svd((to - a).T @ (points - b))
    R = u @ np.diag([1.0, 1.0, np.linalg.det(u) * np.linalg.det(vt)]) @ vt
    return R, a - R @ b
