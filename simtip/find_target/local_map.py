"""From pixels back to the board: a homography, bent near each point to follow the points around.

A homography alone is off by several pixels where the lens distorts or the board is bowed. What is
left of it is smooth, so a weighted polynomial of second degree around each point describes it.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial import cKDTree

from simtip.geometry import Array
from simtip.target import Lattice

NEIGHBOURS = 25
"""Points that a local polynomial rests on, itself among them: two steps each way."""

REACH = 1.5
"""Steps of the lattice at which a neighbour's weight is down to exp(-1/2)."""

RIDGE = (1e-6, 1e-3, 3e-2)
"""Pull of the terms of degree 0, 1 and 2 towards the homography alone, against a weight of 1."""

NEWTON_STEPS = 4


@dataclass(frozen=True, eq=False)
class LocalMap:
    """Maps pixels near one point to the lattice.

    Attributes
    ----------
    homography
        (3, 3) pixels to lattice.
    middle
        (2,) u, v around which the polynomial is written.
    step_px
        Unit of the polynomial's argument.
    bend
        (6, 2) coefficients of 1, d, e, d^2, d e, e^2 in lattice steps.
    """

    homography: Array
    middle: Array
    step_px: float
    bend: Array

    def lattice(self, pixels: Array) -> Array:
        """Map pixels (m, 2) to the lattice (m, 2)."""
        moved = _projected(self.homography, pixels)
        result: Array = moved + _terms((pixels - self.middle) / self.step_px) @ self.bend
        return result

    def slopes(self, pixel: Array) -> Array:
        """Give the (2, 2) derivatives of the lattice's coordinates (rows) by u and v (columns)."""
        h = 1e-3 * self.step_px
        around = pixel + h * np.array([[1.0, 0], [-1, 0], [0, 1], [0, -1]])
        at = self.lattice(around)
        return np.column_stack([at[0] - at[1], at[2] - at[3]]) / (2 * h)

    def pixel(self, place: Array) -> Array:
        """Find the pixel (2,) of a place (2,) on the lattice near the middle, or NaN."""
        p = self.middle.copy()
        for _ in range(NEWTON_STEPS):
            slopes = self.slopes(p)
            if not np.isfinite(slopes).all() or abs(np.linalg.det(slopes)) < 1e-12:
                return np.full(2, np.nan)
            p = p + np.linalg.solve(slopes, place - self.lattice(p[None])[0])
        return p


def local_maps(places: Lattice | Array, pixels: Array) -> list[LocalMap] | None:
    """Fit a map around each of four or more points.

    Parameters
    ----------
    places
        (n, 2) columns and rows, whole or not, not all on a line.
    pixels
        (n, 2) where they are seen.

    Returns
    -------
    list of LocalMap, or None
        One for each point; None if the points determine no homography.
    """
    homography = None
    if len(places) >= 4:
        homography, _ = cv2.findHomography(pixels, places.astype(np.float64), 0)
    if homography is None or not np.isfinite(homography).all():
        return None
    H = np.asarray(homography, dtype=np.float64)
    left = places - _projected(H, pixels)
    if not np.isfinite(left).all():
        return None
    near = np.asarray(cKDTree(places).query(places, k=min(NEIGHBOURS, len(places)))[1])
    maps = []
    for k, others in enumerate(near):
        square = ((places[others] - places[k]) ** 2).sum(axis=1)
        weight = np.exp(-square / (2 * REACH**2))
        close = others[square <= max(2, square.min(initial=2))]
        away = np.linalg.norm(pixels[close] - pixels[k], axis=1)
        steps = np.linalg.norm(places[close] - places[k], axis=1)
        ratio = away[steps > 0] / steps[steps > 0]
        step = float(np.median(ratio)) if len(ratio) else _step(H, pixels[k])
        terms = _terms((pixels[others] - pixels[k]) / step)
        pull = np.repeat(RIDGE, (1, 2, 3))
        normal = terms.T @ (terms * weight[:, None]) + np.diag(pull)
        bend = np.linalg.solve(normal, terms.T @ (weight[:, None] * left[others]))
        maps.append(LocalMap(H, pixels[k].copy(), step, bend))
    return maps


def _terms(d: Array) -> Array:
    u, v = d[:, 0], d[:, 1]
    return np.column_stack([np.ones(len(d)), u, v, u * u, u * v, v * v])


def _projected(H: Array, pixels: Array) -> Array:
    """Map pixels (m, 2) by a homography."""
    x = pixels @ H[:, :2].T + H[:, 2]
    result: Array = x[:, :2] / x[:, 2:]
    return result


def _step(H: Array, pixel: Array) -> float:
    """Give the pixels that one step of the lattice takes, by the homography alone."""
    at = _projected(H, pixel + np.array([[0.0, 0], [1, 0], [0, 1]]))
    return float(1 / max(*np.linalg.norm(at[1:] - at[0], axis=1), 1e-9))
