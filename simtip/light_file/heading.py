"""What a light file says of itself: JSON in an attribute."""

from __future__ import annotations

import json
import zlib
from typing import Any

import numpy as np

from simtip.errors import InputError
from simtip.light_file.exr import Head, Part
from simtip.mix import AMBIENT

ATTRIBUTE = "simtip"
FORMAT = 2
MAX_GROUPS = 256
MAX_PIXELS = 100_000_000
REMEDY = "give a file that `simtip render --lights` wrote"


def parse(heads: list[Head]) -> dict[str, Any]:
    """Read the attribute, and refuse what no light file would have.

    Raises
    ------
    InputError
        There is none, it is of another format, or it names no light groups; or a part is too large.
    """
    text = heads[0].attributes.get(ATTRIBUTE)
    try:
        about = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        about = None
    if not isinstance(about, dict) or not isinstance(about.get("format"), int):
        raise InputError("holds no light groups", remedy=REMEDY)
    if about["format"] != FORMAT:
        raise InputError(
            f"is a light file of format {about['format']}, and this simtip reads format {FORMAT}",
            remedy="render the scene anew with `simtip render --lights`",
        )
    lamps = about.get("lamps")
    if not isinstance(lamps, list) or lamps[-1:] != [AMBIENT] or len(lamps) > MAX_GROUPS:
        raise InputError("names no light groups", remedy=REMEDY)
    for head in heads:
        width, height = head.window.width, head.window.height
        if width <= 0 or not 0 < width * height <= MAX_PIXELS:
            raise InputError(
                f"has {width}x{height} px, and {MAX_PIXELS} pixels is the limit", remedy=REMEDY
            )
    return about


def checksums(parts: dict[str, Part]) -> dict[str, int]:
    """Give the CRC-32 of every channel's bytes, row by row.

    Unpacked pixels bear no checksum of OpenEXR's, and a picture with a hole looks like a picture.
    """
    return {
        name: zlib.crc32(np.ascontiguousarray(pixels).data)
        for part in parts.values()
        for name, pixels in part.channels.items()
    }
