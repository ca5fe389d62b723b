"""An image as a file for another program."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, TypeAlias, cast

import numpy as np

from simtip.detect.gray import LUMA_WEIGHTS
from simtip.detect.protocol import Image
from simtip.errors import InputError
from simtip.image_file import Image as Stored
from simtip.image_file import write_png
from simtip.output_folder import write_atomically

ImageFormat: TypeAlias = Literal["png", "pgm"]


@contextmanager
def handed_over(image: Image, image_format: ImageFormat) -> Iterator[Path]:
    """Give a file that holds the image, as long as the block lasts.

    Parameters
    ----------
    image
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16.
    image_format
        ``png`` keeps every value; ``pgm`` is gray: see `pgm_bytes`.

    Raises
    ------
    InputError
        There is no room for the file.
    """
    try:
        folder = tempfile.TemporaryDirectory(prefix="simtip-", ignore_cleanup_errors=True)
    except OSError as error:
        raise InputError(
            f"cannot be made ({error.strerror})",
            file="temporary folder",
            remedy="free some space, or set TMPDIR",
        ) from error
    with folder as name:
        # Absolute, so that no name of a file is ever taken for an option.
        file = Path(name).absolute() / f"image.{image_format}"
        if image_format == "png":
            write_png(file, cast("Stored", image))
        else:
            write_atomically(file, pgm_bytes(image))
        yield file


def pgm_bytes(image: Image) -> bytes:
    """Write a binary PGM (P5): one byte a pixel, or two, the high one first, of a 16-bit image.

    Colour becomes gray by the weights of ITU-R BT.601, rounded, in the depth of the image.
    """
    gray = image
    if image.ndim == 3:
        gray = np.rint(image @ np.array(LUMA_WEIGHTS)).astype(image.dtype)
    height, width = gray.shape
    head = f"P5\n{width} {height}\n{np.iinfo(gray.dtype).max}\n"
    return head.encode("ascii") + gray.astype(gray.dtype.newbyteorder(">")).tobytes()
