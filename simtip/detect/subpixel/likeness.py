"""How alike what a fit leaves is in neighbouring pixels: of those, fewer count as independent.

Lossy storage, a mosaic of colours and a model that does not quite hold leave residuals that go on
over some pixels. A sum over pixels then scatters by more than their number says (Newey and West,
1987; in the plane Conley, "GMM estimation with cross sectional dependence", 1999).
"""

from __future__ import annotations

import cv2
import numpy as np

from simtip.geometry import Array

REACH_PX = 8
"""A block's side in JPEG: pixels so far apart are not alike."""

_WEIGHTS = 1 - np.abs(np.arange(1 - REACH_PX, REACH_PX)) / REACH_PX


def likeness(over_noise: Array) -> float:
    """Give by how much the variance of sums over pixels exceeds that of independent ones.

    Parameters
    ----------
    over_noise
        (H, W) residuals over the noise's deviation, 0 where a pixel does not count.
    """
    near = cv2.sepFilter2D(
        over_noise, cv2.CV_64F, _WEIGHTS, _WEIGHTS, borderType=cv2.BORDER_CONSTANT
    )
    total = float((over_noise**2).sum())
    return float((over_noise * near).sum()) / total if total > 0 else 1.0
