"""Images as they come back from lossy storage."""

from __future__ import annotations

import tempfile
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

JPEG_QUALITY = 40
FRAMES = 5
"""The image is the last of so many equal ones: a codec that predicts has then settled."""

Picture = NDArray[np.uint8]


def jpeg(image: Picture) -> Picture:
    """Store an image (H, W, 3) RGB, 8 bit, as JPEG, chroma at half the resolution."""
    options = [
        *(cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY),
        *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420),
    ]
    _, data = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), options)
    return _rgb(cv2.imdecode(data, cv2.IMREAD_COLOR))


def mpeg4(image: Picture) -> Picture:
    """Store an image (H, W, 3) RGB, 8 bit, as MPEG-4 part 2 video, at OpenCV's own bit rate.

    A border that makes width and height even, as the codec wants them, is taken off again.
    """
    height, width = image.shape[:2]
    even = np.pad(image, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "needle.mp4"
        size = (even.shape[1], even.shape[0])
        writer = cv2.VideoWriter(str(file), cv2.VideoWriter.fourcc(*"mp4v"), 25, size)
        if not writer.isOpened():
            raise SystemExit("this OpenCV writes no MPEG-4: leave the condition 'video' out")
        for _ in range(FRAMES):
            writer.write(cv2.cvtColor(even, cv2.COLOR_RGB2BGR))
        writer.release()
        reader = cv2.VideoCapture(str(file))
        frames = [reader.read()[1] for _ in range(FRAMES)]
        reader.release()
    return _rgb(frames[-1][:height, :width])


def _rgb(image: NDArray[np.generic]) -> Picture:
    return np.ascontiguousarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), dtype=np.uint8)
