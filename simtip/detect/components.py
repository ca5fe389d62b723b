"""Connected components of a two-level image, and the direction of the one at the tip."""

from __future__ import annotations

from typing import Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.detect.gray import Gray
from simtip.geometry import Array

Connectivity: TypeAlias = Literal[4, 8]

MIN_ELONGATION = 2.0
"""A component less elongated than this (ratio of standard deviations) has no axis to speak of."""


def components(
    binary: Gray, connectivity: Connectivity = 8, value: int = 0
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Label the connected components of the pixels that equal `value`.

    Returns
    -------
    labels
        (H, W), 0 for all other pixels, then 1, 2, ...
    areas
        Pixels with each label, at the label's index.
    """
    mask = (binary == value).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=connectivity)
    areas = np.asarray(stats[:count, cv2.CC_STAT_AREA], dtype=np.int64)
    return np.asarray(labels, dtype=np.int32), areas


def needle_axis(binary: Gray, tip_px: Array, connectivity: Connectivity = 8) -> Array | None:
    """Estimate the needle's direction as the principal axis of the component at the tip.

    Every pixel of the component counts alike, so the direction hardly depends on the tip's
    shape. The paper has no such step; it serves pictures and checks, not the tip's position.

    Parameters
    ----------
    binary
        (H, W) uint8, needle 0.
    tip_px
        (2,) u, v.
    connectivity
        4 or 8.

    Returns
    -------
    Array or None
        (2,) unit direction from the tip towards the component's centroid, or None if no
        component is within 1 px of the tip or it is less elongated than `MIN_ELONGATION`.
    """
    labels, _ = components(binary, connectivity)
    # An edge pixel lies on the needle or next to it.
    u, v = (int(c) for c in np.floor(tip_px + 0.5))
    near = labels[max(v - 1, 0) : v + 2, max(u - 1, 0) : u + 2]
    if not near.any():
        return None
    label = int(np.bincount(near[near > 0]).argmax())
    count, sums, second = _moments(labels == label)
    variances, directions = np.linalg.eigh(second)
    # 1/12: a pixel is a square, so a line one pixel wide is no line of width 0
    if variances[1] + 1 / 12 < MIN_ELONGATION**2 * (variances[0] + 1 / 12):
        return None
    axis: Array = directions[:, 1]
    towards = np.array([sums[0] - count * tip_px[0], sums[1] - count * tip_px[1]])
    return axis if axis @ towards >= 0 else -axis


def _moments(mask: NDArray[np.bool_]) -> tuple[int, tuple[int, int], Array]:
    """Count pixels, sum u and v, and work out the covariance of (u, v), (2, 2) px^2.

    Sums are whole numbers, so a part of the image gives the covariance of all of it, to the bit.
    """
    vs, us = np.nonzero(mask)
    n, s_u, s_v = len(us), int(us.sum()), int(vs.sum())
    uu = n * int((us * us).sum()) - s_u * s_u
    uv = n * int((us * vs).sum()) - s_u * s_v
    vv = n * int((vs * vs).sum()) - s_v * s_v
    covariance = np.array([[uu / n**2, uv / n**2], [uv / n**2, vv / n**2]])
    return n, (s_u, s_v), covariance
