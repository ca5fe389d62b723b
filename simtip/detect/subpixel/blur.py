"""The lens's blur: how it takes away detail along a direction, and the blurred picture.

Far out of focus a point becomes a disc, an image of the lens's opening; near the focus aberration
and diffraction make a Gaussian of it. Here the blur is a disc and a Gaussian in succession, told by
their variance together along one direction and by the disc's share of it. A Gaussian alone, taken
for a disc, gives a needle a wrong width: it would be wider, with bright rims.

Source: Goodman, Introduction to Fourier Optics, 6.4 (defocus; of geometrical optics, for incoherent
light, the disc).
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
import scipy
from numpy.typing import NDArray

from simtip.geometry import Array

LEAST_SHARE = 0.05
"""Of a disc, at which a derivative is taken in place of none."""

FINE = 8
"""Points across a cell, to draw the disc."""


def transfer(f: Array, variance_px2: float | Array, disc_share: float) -> tuple[Array, Array]:
    """Give what is left of frequencies along a direction, and its derivative by the variance.

    Parameters
    ----------
    f
        (n,) cycles per pixel.
    variance_px2
        Of the blur along the direction, px^2; or some, (m, 1).
    disc_share
        Of the variance, 0 to 1, what is the disc's.
    """
    power = 2 * np.pi**2 * f**2
    round_variance = (1 - disc_share) * variance_px2
    spread = np.exp(-power * round_variance)
    by_variance = -power * (1 - disc_share) * spread
    if disc_share > 0:
        # A disc of radius r has variance r^2 / 4: its transfer function is 2 J1(q) / q at
        # q = 2 pi f r, of which the derivative by q is -2 J2(q) / q.
        q = np.maximum(4 * np.pi * np.sqrt(disc_share * variance_px2) * f, 1e-6)
        disc = 2 * scipy.special.j1(q) / q
        by_variance = by_variance * disc - spread * scipy.special.jv(2, q) / variance_px2
        spread = spread * disc
    return spread, by_variance


def transfer_by_share(f: Array, variance_px2: float | Array, disc_share: float) -> Array:
    """Give the derivative of `transfer` by the square of the disc's share.

    By the share itself it is nothing where there is no disc: of a little one only the variance is
    seen.
    """
    power, share = 2 * np.pi**2 * f**2, max(disc_share, LEAST_SHARE)
    q = np.maximum(4 * np.pi * np.sqrt(share * variance_px2) * f, 1e-6)
    by_disc = power * variance_px2 * 2 * scipy.special.j1(q) / q - scipy.special.jv(2, q) / share
    return np.asarray(by_disc * np.exp(-power * (1 - share) * variance_px2) / (2 * share))


def blurred(
    cells: NDArray[np.float32],
    variance_px2: float,
    disc_share: float,
    per_px: tuple[int, int],
) -> NDArray[np.float32]:
    """Blur an image (H, W) of cells.

    Parameters
    ----------
    cells
        It.
    variance_px2, disc_share
        See `transfer`.
    per_px
        Rows and columns of cells to a pixel.
    """
    rows, columns = per_px
    if disc_share > 0:
        kernel = _kernel(variance_px2, disc_share, rows, columns)
        return np.asarray(
            cv2.filter2D(cells, cv2.CV_32F, kernel, borderType=cv2.BORDER_REPLICATE), np.float32
        )
    sigma = float(np.sqrt(variance_px2))
    return np.asarray(
        cv2.GaussianBlur(
            cells, (0, 0), sigma * columns, sigmaY=sigma * rows, borderType=cv2.BORDER_REPLICATE
        ),
        np.float32,
    )


@lru_cache(maxsize=8)
def _kernel(variance_px2: float, disc_share: float, rows: int, columns: int) -> NDArray[np.float32]:
    """Give disc and Gaussian together, a weight a cell."""
    radius = 2 * float(np.sqrt(disc_share * variance_px2))
    # Weights are the disc's means over cells, which spread it by the cell.
    rest = np.maximum((1 - disc_share) * variance_px2 - 1 / 12 / np.array([rows, columns]) ** 2, 0)
    sigma_v, sigma_u = np.sqrt(rest)
    reach_v = int(np.ceil((radius + 3 * sigma_v) * rows)) + 1
    reach_u = int(np.ceil((radius + 3 * sigma_u) * columns)) + 1
    v = (np.arange((2 * reach_v + 1) * FINE) + 0.5) / FINE - reach_v - 0.5
    u = (np.arange((2 * reach_u + 1) * FINE) + 0.5) / FINE - reach_u - 0.5
    inside = ((v[:, None] / rows) ** 2 + (u / columns) ** 2 < radius**2).astype(np.float32)
    kernel = cv2.resize(inside, (2 * reach_u + 1, 2 * reach_v + 1), interpolation=cv2.INTER_AREA)
    for sigma, axis in ((sigma_v * rows, 0), (sigma_u * columns, 1)):
        if sigma > 0:
            x = np.arange(kernel.shape[axis]) - kernel.shape[axis] // 2
            weights = np.exp(-0.5 * (x / sigma) ** 2)
            sizes = (1, len(x)) if axis == 1 else (len(x), 1)
            kernel = cv2.filter2D(
                kernel, -1, weights.reshape(sizes), borderType=cv2.BORDER_CONSTANT
            )
    return np.asarray(kernel / kernel.sum(), np.float32)
