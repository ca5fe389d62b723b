"""Photographs of calibration targets with known truth, made without the renderer or `simtip`.

The pattern is a formula (squares by their parity, circles by distance) or, for ChArUco, OpenCV's
own drawing of the board. Each pixel integrates it over its area: by 16 x 16 samples where an edge
passes through.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

Ink = Callable[[np.ndarray, np.ndarray], np.ndarray]
SAMPLES = 16


def chessboard(columns: int, rows: int, square: float, first: int = 0) -> Ink:
    """Squares around columns x rows inner corners; the upper left is black if `first` is 0."""

    def ink(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        i, j = np.floor(x / square).astype(int) + 1, np.floor(y / square).astype(int) + 1
        inside = (i >= 0) & (i <= columns) & (j >= 0) & (j <= rows)
        return (inside & ((i + j) % 2 == first)).astype(np.float32)

    return ink


def circles(centres: np.ndarray, diameter: float) -> Ink:
    """Discs at centres (n, 2)."""

    def ink(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        shape, black = x.shape, np.zeros(x.size, bool)
        x, y = x.ravel(), y.ravel()
        for cx, cy in centres:
            black |= (x - cx) ** 2 + (y - cy) ** 2 <= (diameter / 2) ** 2
        return black.reshape(shape).astype(np.float32)

    return ink


def charuco(
    columns: int, rows: int, square: float, marker: float, dictionary: str = "DICT_4X4_50"
) -> Ink:
    """Read OpenCV's drawing, 80 pixels a square; origin at the first inner corner."""
    fine = 80
    names = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    board = cv2.aruco.CharucoBoard((columns, rows), square, marker, names)
    drawn = board.generateImage((columns * fine, rows * fine), marginSize=0, borderBits=1)

    def ink(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        i = np.floor((x / square + 1) * fine).astype(int)
        j = np.floor((y / square + 1) * fine).astype(int)
        inside = (i >= 0) & (i < columns * fine) & (j >= 0) & (j < rows * fine)
        value = drawn[j.clip(0, rows * fine - 1), i.clip(0, columns * fine - 1)]
        return (inside & (value < 128)).astype(np.float32)

    return ink


@dataclass
class Photographer:
    """A camera with distortion, and what it does to light."""

    K: np.ndarray
    size: tuple[int, int]
    distortion: np.ndarray = field(default_factory=lambda: np.zeros(5))
    blur_px: float = 1.0
    noise_dn: float = 0.0
    paper_dn: float = 200.0
    ink_dn: float = 30.0
    falloff: float = 0.0
    disc: bool = False
    finer: int = 1  # blur on a grid so much finer than the pixels: below 1 px of blur it matters

    def pixels(self, points: np.ndarray, rvec: np.ndarray, tvec: np.ndarray) -> np.ndarray:
        """Project points (n, 3) of the board."""
        points = np.asarray(points, float).reshape(-1, 1, 3)
        return cv2.projectPoints(points, rvec, tvec, self.K, self.distortion)[0].reshape(-1, 2)

    def coverage(self, ink: Ink, box: np.ndarray, rvec: np.ndarray, tvec: np.ndarray) -> np.ndarray:
        """Give the inked part of each pixel's area (H, W); `box` bounds the pattern, mm."""
        w, h = self.size
        edge = np.linspace(0, 1, 60)[:, None]
        corners = np.array([box[0], [box[1][0], box[0][1]], box[1], [box[0][0], box[1][1]]])
        outline = np.concatenate(
            [a + edge * (b - a) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)]
        )
        seen = self.pixels(np.column_stack([outline, np.zeros(len(outline))]), rvec, tvec)
        lo = np.clip(np.floor(seen.min(axis=0)).astype(int) - 4, 0, [w, h])
        hi = np.clip(np.ceil(seen.max(axis=0)).astype(int) + 5, lo, [w, h])
        whole = np.zeros((h, w), np.float32)
        if (hi <= lo).any():
            return whole
        # Where the corners of the pixels lie on the board.
        u, v = np.meshgrid(np.arange(lo[0], hi[0] + 1) - 0.5, np.arange(lo[1], hi[1] + 1) - 0.5)
        R = cv2.Rodrigues(np.asarray(rvec, float))[0]
        to_board = np.linalg.inv(np.column_stack([R[:, :2], np.asarray(tvec, float)]))
        ends = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-12)
        uv = np.column_stack([u.ravel(), v.ravel()])[:, None]
        n = cv2.undistortPoints(uv, self.K, self.distortion, criteria=ends).reshape(-1, 2)
        xyw = np.column_stack([n, np.ones(len(n))]) @ to_board.T
        x, y = (xyw[:, 0] / xyw[:, 2]).reshape(u.shape), (xyw[:, 1] / xyw[:, 2]).reshape(u.shape)
        at = ink(x, y)
        nearby = cv2.dilate(at, np.ones((3, 3))) != cv2.erode(at, np.ones((3, 3)))
        edges = nearby[:-1, :-1] | nearby[1:, :-1] | nearby[:-1, 1:] | nearby[1:, 1:]
        part = at[:-1, :-1].copy()
        j, i = np.nonzero(edges)
        # Sheared both ways, so that an edge along a row or a column meets 256 places, not 16.
        row, column = np.indices((SAMPLES, SAMPLES)) + 0.5
        p, q = (row + column / SAMPLES - 0.5) / SAMPLES, (column + row / SAMPLES - 0.5) / SAMPLES
        for first in range(0, len(i), 8192):
            a, b = j[first : first + 8192, None, None], i[first : first + 8192, None, None]
            xs, ys = (
                (1 - p) * ((1 - q) * m[a, b] + q * m[a, b + 1])
                + p * ((1 - q) * m[a + 1, b] + q * m[a + 1, b + 1])
                for m in (x, y)
            )
            part[a[:, 0, 0], b[:, 0, 0]] = ink(xs, ys).mean(axis=(1, 2))
        whole[lo[1] : hi[1], lo[0] : hi[0]] = part
        return whole

    def shoot(
        self, ink: Ink, box: np.ndarray, rvec: np.ndarray, tvec: np.ndarray, seed: int = 0
    ) -> np.ndarray:
        """Take the 8-bit gray image (H, W)."""
        if self.finer > 1:
            light = self._fine(ink, box, rvec, tvec)
        else:
            light = self._blurred(self.coverage(ink, box, rvec, tvec), self.blur_px)
        light = self.paper_dn - (self.paper_dn - self.ink_dn) * light
        w = light.shape[1]
        light = light * (1 - self.falloff * np.linspace(0, 1, w)[None, :])
        noise = np.random.default_rng(seed).normal(0, 1, light.shape) * self.noise_dn
        return np.clip(np.rint(light + noise), 0, 255).astype(np.uint8)

    def _blurred(self, image: np.ndarray, blur_px: float) -> np.ndarray:
        if self.disc:
            return cv2.filter2D(image, -1, _disc(2 * blur_px), borderType=cv2.BORDER_REPLICATE)
        return cv2.GaussianBlur(image, (0, 0), blur_px) if blur_px else image

    def _fine(self, ink: Ink, box: np.ndarray, rvec: np.ndarray, tvec: np.ndarray) -> np.ndarray:
        n = self.finer
        K = np.array([[n, 0, (n - 1) / 2], [0, n, (n - 1) / 2], [0, 0, 1]]) @ self.K
        w, h = self.size
        fine = replace(self, K=K, size=(n * w, n * h), finer=1)
        light = self._blurred(fine.coverage(ink, box, rvec, tvec), n * self.blur_px)
        return light.reshape(h, n, w, n).mean(axis=(1, 3))


def _disc(radius: float) -> np.ndarray:
    """A defocused point: its SD along an axis is half its radius."""
    n, fine = int(np.ceil(radius)) + 1, 16
    x = (np.arange((2 * n + 1) * fine) + 0.5) / fine - n - 0.5
    inside = (x[:, None] ** 2 + x[None, :] ** 2 <= radius**2).astype(np.float64)
    kernel = inside.reshape(2 * n + 1, fine, 2 * n + 1, fine).sum(axis=(1, 3))
    return kernel / kernel.sum()


def pose(
    tilt_deg: float, turn_deg: float, roll_deg: float, middle: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Place the board's point `middle` (2,) at `at` (3,), tilted about an axis at `turn`."""
    t, r = np.radians([turn_deg, roll_deg])
    tilt = cv2.Rodrigues(np.radians(tilt_deg) * np.array([np.cos(t), np.sin(t), 0.0]))[0]
    R = tilt @ cv2.Rodrigues(np.array([0.0, 0.0, r]))[0]
    return cv2.Rodrigues(R)[0].ravel(), np.asarray(at, float) - R @ np.array([*middle, 0.0])
