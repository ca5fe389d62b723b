"""An image as simtip wrote it, of the size of the camera that took it."""

from __future__ import annotations

from pathlib import Path

from simtip.camera import Camera
from simtip.errors import InputError
from simtip.image_file import read_image
from simtip.sensor import Image


def read_taken(file: Path, camera: Camera, remedy: str) -> Image:
    """Read an image that a camera took, (H, W, 3).

    Raises
    ------
    InputError
        It cannot be read, is cut short, gray, or of another size.
    """
    image = read_image(file)
    if image.shape != (camera.height, camera.width, 3):
        size = " x ".join(map(str, (image.shape[1], image.shape[0], *image.shape[2:])))
        raise InputError(
            f"has {size} values, and its camera {camera.width} x {camera.height} x 3",
            file=file,
            remedy=remedy,
        )
    return image
