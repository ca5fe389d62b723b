"""Candidates for corners of a chessboard: saddles of brightness with two dark and two bright sides.

The determinant of the Hessian finds saddles; a ring of samples around each tells corners (mostly
the second harmonic, alike after half a turn) from the rest, whatever the contrast.
"""

from __future__ import annotations

import cv2
import numpy as np

from simtip.find_target.candidates import Candidates
from simtip.find_target.gray import Gray
from simtip.geometry import Array

BLUR_PX = 1.5
"""SD of the blur before differentiating."""

RING_PX, RING_SAMPLES = 4.5, 16

MOST = 4000
"""Saddles that are looked at, strongest first."""

SECOND_HARMONIC, UNEVEN = 0.5, 0.25
"""Least part of the ring's variance in the second harmonic; most in odd harmonics."""

FAINTEST = 1e-5
"""Least variance on a ring, of full scale: two 8-bit steps between black and white."""

APART_PX = 5


def saddles(gray: Gray) -> Candidates:
    """Find candidates in (H, W) gray values."""
    soft = np.asarray(cv2.GaussianBlur(gray, (0, 0), BLUR_PX), dtype=np.float32)
    uu = cv2.Sobel(soft, cv2.CV_32F, 2, 0, ksize=3)
    vv = cv2.Sobel(soft, cv2.CV_32F, 0, 2, ksize=3)
    uv = cv2.Sobel(soft, cv2.CV_32F, 1, 1, ksize=3)
    strength = uv * uv * 4 - uu * vv
    highest = cv2.dilate(strength, np.ones((APART_PX, APART_PX), np.uint8))
    rows, columns = np.nonzero((strength == highest) & (strength > 0))
    order = np.argsort(-strength[rows, columns], kind="stable")[:MOST]
    pixels = np.column_stack([columns[order], rows[order]]).astype(np.float64)
    corner, phase = _ring(soft, pixels)
    return Candidates(pixels[corner], phase[corner], np.full(np.count_nonzero(corner), np.nan))


def _ring(soft: Gray, pixels: Array) -> tuple[np.ndarray[tuple[int], np.dtype[np.bool_]], Array]:
    """Say which pixels (n, 2) look like corners, and the phase of each."""
    angle = np.arange(RING_SAMPLES) * (2 * np.pi / RING_SAMPLES)
    ring = pixels[:, None] + RING_PX * np.column_stack([np.cos(angle), np.sin(angle)])
    if not len(pixels):
        return np.zeros(0, dtype=np.bool_), np.zeros(0)
    uv = ring.astype(np.float32)
    values = cv2.remap(
        soft, uv[..., 0], uv[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT
    )
    harmonics = np.fft.rfft(np.asarray(values, dtype=np.float64), axis=1) / RING_SAMPLES
    power = 2 * np.abs(harmonics) ** 2
    power[:, -1] /= 2
    total = power[:, 1:].sum(axis=1)
    good = (total > FAINTEST) & (power[:, 2] > SECOND_HARMONIC * total)
    good &= power[:, 1::2].sum(axis=1) < UNEVEN * total
    return good, np.angle(harmonics[:, 2])
