"""Needles of metal drawn as a camera sees them, on their own: nothing of the detector is used.

Every fine row is covered exactly, so edges lie where they should to a thousandth of a pixel. Drawn
tip down; other directions are the same pixels turned.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

ROWS, COLUMNS = 8, 4
"""Cells of a pixel."""

THETA = np.linspace(-np.pi / 2, np.pi / 2, 361)
METAL = (
    0.17
    + 0.28 * np.exp(-0.5 * ((np.pi / 2 - np.abs(THETA)) / 0.5) ** 2)
    + 0.2 * np.exp(-0.5 * ((THETA - 0.35) / 0.22) ** 2)
)
"""Brightness over the background's by the surface's angle: 0.45 at the rims, a streak within."""


@dataclass(frozen=True)
class Drawn:
    """A needle and its camera.

    Attributes
    ----------
    point
        Corners (n, 2) x, z of the point from its left to its right shoulder, in half widths, z from
        the apex towards the hub, convex.
    width_px, tip_px, degrees
        Width, apex, and by how much the needle leans: its hub lies up and so far to the left.
    sigma_px, disc_px, ground_dn
        Gaussian blur, radius of the disc of a lens out of focus, and background.
    contrast
        1 for metal of which the rims mirror 0.45 of the background; less is paler.
    facet, facet_level
        Outline (m, 2) of a flat cut, as `point`, or None; its brightness over the background's.
    streak
        Where a lamp's bright line lies across the needle, x over the half width there, how wide
        it is of that, and its brightness over the background's; or None.
    cut
        Whether the point is what a cut has left of the shaft, curved as before, and no cone.
    """

    point: tuple[tuple[float, float], ...] = ((-1, 4), (0, 0), (1, 4))
    width_px: float = 20.0
    tip_px: tuple[float, float] = (110.3, 230.6)
    degrees: float = 7.0
    sigma_px: float = 0.7
    disc_px: float = 0.0
    ground_dn: float = 190.0
    contrast: float = 1.0
    shape: tuple[int, int] = (260, 220)
    facet: tuple[tuple[float, float], ...] | None = None
    facet_level: float = 1.3
    streak: tuple[float, float, float] | None = None
    cut: bool = False

    @property
    def axis(self):
        """Unit direction from tip to hub, (2,)."""
        lean = np.radians(self.degrees)
        return np.array([-np.sin(lean), -np.cos(lean)])

    def placed(self, corners):
        """Put corners (n, 2) in half widths into the image: u, v."""
        hub = self.axis
        across = np.array([-hub[1], hub[0]])
        corners = np.asarray(corners, float) * self.width_px / 2
        return np.array(self.tip_px) + corners[:, :1] * across + corners[:, 1:] * hub

    def light(self):
        """Give the picture (H, W) without noise, DN."""
        height, width = self.shape
        pad = int(np.ceil(4 * self.sigma_px + self.disc_px)) + 1
        v = (np.arange((height + 2 * pad) * ROWS) + 0.5) / ROWS - 0.5 - pad
        u = (np.arange((width + 2 * pad) * COLUMNS) / COLUMNS - 0.5 - pad).astype(np.float32)
        sides = self.point[0][0], self.point[-1][0]
        outline = [(sides[0], 1e4), *self.point, (sides[1], 1e4)]
        left, right = chord(self.placed(outline), v)
        inside = between(u, left, right)
        shaft = self.placed([(x, z) for x in sides for z in (-1e4, 1e4)])[[0, 1, 3, 2]]
        low, high = chord(shaft, v)
        if not self.cut:
            # On the point the flanks, on the shaft its sides, bound what is curved.
            low, high = np.maximum(low, left), np.minimum(high, right)
        middle, half = (low + high) / 2, np.maximum((high - low) / 2, 1e-6)
        middle, half = middle.astype(np.float32), half.astype(np.float32)
        s = np.clip((u + 0.5 / COLUMNS - middle[:, None]) / half[:, None], -1, 1)
        seen = self.ground_dn * (1 + self.contrast * (metal(s) - 1))
        if self.streak is not None:
            x, wide, level = self.streak
            seen += (np.abs(s - x) < wide / 2) * (self.ground_dn * level - seen)
        fine = (self.ground_dn + inside * (seen - self.ground_dn)).astype(np.float32)
        if self.facet is not None:
            # What of a cell is the facet's is not the shaft's: at the rim nothing shows through.
            cut = np.minimum(between(u, *chord(self.placed(self.facet), v)), inside)
            fine += cut * (self.ground_dn * self.facet_level - seen)
        if self.sigma_px:
            size = [2 * int(np.ceil(4 * self.sigma_px * cells)) + 1 for cells in (COLUMNS, ROWS)]
            sigma = self.sigma_px * COLUMNS, self.sigma_px * ROWS
            fine = cv2.GaussianBlur(fine, size, sigma[0], sigmaY=sigma[1])
        if self.disc_px:
            fine = cv2.filter2D(fine, -1, disc(self.disc_px))
        fine = fine[pad * ROWS : -pad * ROWS, pad * COLUMNS : -pad * COLUMNS]
        return fine.reshape(height, ROWS, width, COLUMNS).mean(axis=(1, 3)).astype(np.float64)

    def but(self, **changed):
        """Give the same needle, some of it changed."""
        return replace(self, **changed)


def disc(radius_px):
    """Give a disc's part of each cell, of 1, from 16 x 16 points a cell."""
    spots = (np.arange(16) + 0.5) / 16 - 0.5
    reach = [int(np.ceil(radius_px * cells)) + 1 for cells in (ROWS, COLUMNS)]
    v, u = (
        (np.arange(-most, most + 1)[:, None] + spots).reshape(-1) / cells
        for most, cells in zip(reach, (ROWS, COLUMNS), strict=True)
    )
    inside = np.hypot(v[:, None], u) < radius_px
    sizes = 2 * reach[0] + 1, 16, 2 * reach[1] + 1, 16
    kernel = inside.reshape(sizes).mean(axis=(1, 3))
    return kernel / kernel.sum()


def metal(s):
    """Brightness over the background's at s = x / half width: bright rims, a streak within."""
    return np.interp(s, np.sin(THETA), METAL).astype(np.float32)


def chord(corners, v):
    """Give where rows v cut a convex outline: its least and greatest u, equal where they miss."""
    left, right = np.full(len(v), np.inf), np.full(len(v), -np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if a[1] == b[1]:
            continue
        cut = (v >= min(a[1], b[1])) & (v < max(a[1], b[1]))
        u = a[0] + (v - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
        left = np.where(cut, np.minimum(left, u), left)
        right = np.where(cut, np.maximum(right, u), right)
    missed = left > right
    return np.where(missed, 0, left), np.where(missed, 0, right)


def between(u, left, right):
    """Give the part of each cell from u to u + 1 / COLUMNS that lies between left and right."""
    ends = (end.astype(np.float32) for end in (left, right))
    at_left, at_right = (np.clip((end[:, None] - u) * COLUMNS, 0, 1) for end in ends)
    return at_right - at_left


def photograph(light, seed, noise_dn=1.5):
    """Give an 8-bit picture with noise."""
    noise = np.random.default_rng([6, seed]).normal(0, noise_dn, light.shape)
    return np.clip(np.rint(light + noise), 0, 255).astype(np.uint8)


def bevel(cot, azimuth, **changed):
    """Give a bevel seen at right angles, whose cut looks at the camera, or without a facet away.

    `azimuth` is the apex's against x.
    """
    angle = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    rim = np.column_stack([np.cos(angle - azimuth), cot * (1 - np.cos(angle))])
    rim -= rim[0]
    front = np.column_stack([np.cos(angle - azimuth), np.sin(angle - azimuth)])[:, 1] <= 0
    point = rim[front]
    corners = {
        "point": tuple(map(tuple, point[np.argsort(point[:, 0])])),
        "facet": tuple(map(tuple, rim)),
    }
    return Drawn(**(corners | changed), cut=True)


def off(observation, drawn):
    """Give the tip's error along and across the axis, px; positive along is short of the tip."""
    assert observation.ok, observation.reason
    error = observation.tip_px - np.array(drawn.tip_px)
    axis = drawn.axis
    return float(error @ axis), float(error @ np.array([-axis[1], axis[0]]))
