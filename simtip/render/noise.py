"""How far a rendered view may be off by chance: its Monte-Carlo error, pixel by pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Noise:
    """Monte-Carlo error of a view's response, averaged over the three channels.

    Attributes
    ----------
    open_sd
        (groups, H, W) float32, standard deviation per group where pixels were not sampled on their
        own; groups are independent there. 0 at `pixels`.
    pixels
        (n,) flat indices of pixels that were sampled on their own.
    covariance
        (n, groups, groups) float32 of their groups, which share mirrored rays. Found from four
        independent replicas of each pixel, averaged over its eight neighbours.
    samples
        (n,) how many samples each of them took.
    """

    open_sd: Floats
    pixels: NDArray[np.uint32]
    covariance: Floats
    samples: NDArray[np.uint32]

    def sd(self, weights: ArrayLike) -> Floats:
        """Give the standard deviation (H, W) of a mix of the groups, mean over the channels.

        Parameters
        ----------
        weights
            (groups,) or (groups, 3) radiance of each group.
        """
        w = np.asarray(weights, np.float32)
        w = w if w.ndim == 1 else w.mean(axis=1)
        total = np.zeros(self.open_sd.shape[1:], np.float32)
        for factor, sd in zip(w, self.open_sd, strict=True):
            if factor:
                total += (factor * sd) ** 2
        total.reshape(-1)[self.pixels] = np.einsum("i,nij,j->n", w, self.covariance, w)
        deviation: Floats = np.sqrt(np.maximum(total, 0))
        return deviation
