"""Image files of any origin as arrays: what the sensor wrote, pixel for pixel.

OpenCV decodes; `simtip.image_header` refuses before what it would let pass in silence. Rotation
tags are ignored, since a pixel's place in the sensor is what a calibration knows.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
import threading
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.image_header import COPY_AGAIN, SAVE_AGAIN, Header, UnusableError, check_header
from simtip.input_file import read_bytes
from simtip.output_folder import write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Any, BinaryIO

Image: TypeAlias = NDArray[np.uint8] | NDArray[np.uint16]

MAX_BYTES = 1 << 30
"""Largest image file read."""
MAX_PIXELS = 200_000_000
"""Most pixels of an image."""

_stderr_lock = threading.Lock()


def read_image(path: str | Path) -> Image:
    """Read an image file: PNG, TIFF, JPEG or BMP, 8 or 16 bit, gray, colour or palette.

    Values are those in the file, neither scaled nor colour-managed; 1, 2 and 4 bit gray is spread
    over 0..255. An alpha channel is dropped. Orientation tags (EXIF) are not applied.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    ndarray
        (H, W), or (H, W, 3) in RGB order; uint8 or uint16.

    Raises
    ------
    InputError
        The file is missing, not such an image, damaged or cut short, too large, or holds values
        of another kind (float, 32 bit, signed, ...).
    """
    data = read_bytes(path, MAX_BYTES)
    try:
        data, header = check_header(data)
    except UnusableError as error:
        raise InputError(str(error), file=path, remedy=error.remedy) from None
    if not header.width or not header.height:
        raise InputError("has no pixels", file=path, remedy=SAVE_AGAIN)
    if header.width * header.height > MAX_PIXELS:
        raise InputError(
            f"claims {header.width} x {header.height} pixels, more than {MAX_PIXELS}",
            file=path,
            remedy="crop it",
        )
    image = _decode(data, path)
    if image.dtype not in (np.uint8, np.uint16) or image.dtype.itemsize * 8 < header.bits:
        raise InputError(f"holds {image.dtype} values", file=path, remedy=SAVE_AGAIN)
    if image.shape[:2] != (header.height, header.width):
        raise InputError("is damaged: its size changed", file=path, remedy=COPY_AGAIN)
    pixels: Image = _rgb(image, header, path)
    return pixels


def write_png(path: str | Path, image: Image) -> None:
    """Write an image as PNG, which appears whole or not at all.

    Parameters
    ----------
    path
        The file; an existing one is replaced.
    image
        (H, W) or (H, W, 3) in RGB order, uint8 or uint16.

    Raises
    ------
    InputError
        The file cannot be written.
    ValueError
        The array is no such image.
    """
    if image.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"a PNG holds uint8 or uint16, not {image.dtype}")
    if image.ndim not in {2, 3} or image.shape[2:] not in {(), (3,)} or not image.size:
        raise ValueError(f"an image is (H, W) or (H, W, 3), not {image.shape}")
    ordered = image if image.ndim == 2 else image[:, :, ::-1]
    done, encoded = cv2.imencode(".png", np.ascontiguousarray(ordered))
    if not done:
        raise ValueError(f"OpenCV cannot write an image of shape {image.shape} as PNG")
    write_atomically(path, encoded.tobytes())


def _decode(data: bytes, path: str | Path) -> NDArray[Any]:
    """Decode with OpenCV, in silence; what its libraries complain of counts."""
    with _stderr_caught() as caught:
        try:
            decoded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        except cv2.error:
            decoded = None
        caught.seek(0)
        complaints = caught.read(1 << 16)
    # libjpeg fills up with gray what it cannot read, and only says so.
    if decoded is None or re.search(rb"Corrupt JPEG|Premature end", complaints):
        raise InputError("is damaged or cut short", file=path, remedy=COPY_AGAIN)
    return np.asarray(decoded)


@contextmanager
def _stderr_caught() -> Iterator[BinaryIO]:
    """Send the process's error output to a file: C libraries write to it directly."""
    with _stderr_lock, _sink() as caught:
        if sys.stderr is not None:
            sys.stderr.flush()
        try:
            saved = os.dup(2)
        except OSError:  # there is no error output
            yield caught
            return
        try:
            os.dup2(caught.fileno(), 2)
            yield caught
        finally:
            os.dup2(saved, 2)
            os.close(saved)


def _sink() -> BinaryIO:
    try:
        return tempfile.TemporaryFile()
    except OSError:  # no place for temporary files: silence is what remains
        return Path(os.devnull).open("w+b")


def _rgb(image: NDArray[Any], header: Header, path: str | Path) -> NDArray[Any]:
    """Drop alpha and put the channels in RGB order."""
    if image.ndim == 2:
        return image
    if image.shape[2] not in {3, 4}:
        raise InputError(f"has {image.shape[2]} channels", file=path, remedy=SAVE_AGAIN)
    if header.premultiplied and image.shape[2] == 4:
        opaque = np.iinfo(image.dtype).max
        if (image[:, :, 3] != opaque).any():
            raise InputError(
                "is a TIFF with transparent pixels", file=path, remedy="save it without alpha"
            )
    return np.ascontiguousarray(image[:, :, 2::-1])
