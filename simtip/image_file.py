"""Image files of any origin as arrays: what the sensor wrote, pixel for pixel.

OpenCV decodes. What it would let pass in silence is checked before: a file that is cut short, a
header that promises gigabytes, a TIFF whose values OpenCV would change. Rotation tags are ignored,
since a pixel's place in the sensor is what a calibration knows.
"""

from __future__ import annotations

import os
import re
import struct
import sys
import tempfile
import threading
import zlib
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.output_folder import write_atomically
from simtip.yaml_file import read_bytes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import Any, BinaryIO

Image: TypeAlias = NDArray[np.uint8] | NDArray[np.uint16]

MAX_BYTES = 1 << 30
"""Largest image file read."""
MAX_PIXELS = 200_000_000
"""Most pixels of an image."""

MAX_PARTS = 1_000_000
"""Most chunks of a PNG or segments of a JPEG."""

_SAVE_AGAIN = "save it again as PNG, 8 or 16 bit, gray or RGB"
_COPY_AGAIN = "copy or save it again"
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
        data, header = _header(data)
    except _UnusableError as error:
        raise InputError(str(error), file=path, remedy=error.remedy) from None
    except (struct.error, IndexError, zlib.error):
        raise InputError("is cut short", file=path, remedy=_COPY_AGAIN) from None
    if not header.width or not header.height:
        raise InputError("has no pixels", file=path, remedy=_SAVE_AGAIN)
    if header.width * header.height > MAX_PIXELS:
        raise InputError(
            f"claims {header.width} x {header.height} pixels, more than {MAX_PIXELS}",
            file=path,
            remedy="crop it",
        )
    image = _decode(data, path)
    if image.dtype not in (np.uint8, np.uint16) or image.dtype.itemsize * 8 < header.bits:
        raise InputError(f"holds {image.dtype} values", file=path, remedy=_SAVE_AGAIN)
    if image.shape[:2] != (header.height, header.width):
        raise InputError("is damaged: its size changed", file=path, remedy=_COPY_AGAIN)
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


class _UnusableError(Exception):
    """A header says that the file is of no use."""

    def __init__(self, problem: str, remedy: str = _SAVE_AGAIN) -> None:
        super().__init__(problem)
        self.remedy = remedy


@dataclass(frozen=True)
class _Header:
    """What the file promises: size in px, bits per value."""

    width: int
    height: int
    bits: int
    # TIFF: OpenCV multiplies the colours by the alpha channel.
    premultiplied: bool = False


def _header(data: bytes) -> tuple[bytes, _Header]:
    """Check a file's structure; give the bytes to decode and what they promise."""
    for magic, check in _FORMATS.items():
        if data.startswith(magic):
            return check(data)
    raise _UnusableError("is not a PNG, TIFF, JPEG or BMP image")


def _png(data: bytes) -> tuple[bytes, _Header]:
    """Walk the chunks (ISO/IEC 15948, 5.3) up to IEND, checking each CRC."""
    if data[12:16] != b"IHDR":
        raise _UnusableError("is a damaged PNG", _COPY_AGAIN)
    width, height, bits = struct.unpack_from(">IIB", data, 16)
    view = memoryview(data)
    at = 8
    for _ in range(MAX_PARTS):
        length, name = struct.unpack_from(">I4s", data, at)
        (crc,) = struct.unpack_from(">I", data, at + 8 + length)
        if zlib.crc32(view[at + 4 : at + 8 + length]) != crc:
            raise _UnusableError("is a damaged PNG: a checksum is wrong", _COPY_AGAIN)
        if name == b"IEND":
            return data, _Header(width, height, bits)
        at += 12 + length
    raise _UnusableError("is a PNG of too many chunks")


_START_OF_FRAME = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


def _jpeg(data: bytes) -> tuple[bytes, _Header]:
    """Walk the segments (ISO/IEC 10918-1, B.1.1) to the first scan; look for the end marker."""
    at, header = 2, None
    for _ in range(MAX_PARTS):
        mark, code, length = struct.unpack_from(">BBH", data, at)
        if mark != 0xFF or code == 0xDA:
            break
        if code in _START_OF_FRAME and header is None:
            bits, height, width = struct.unpack_from(">BHH", data, at + 4)
            header = _Header(width, height, bits)
        at += 1 if code == 0xFF else 2 + max(length, 2)  # 0xFF: padding before a marker
    if header is None or mark != 0xFF:
        raise _UnusableError("is a damaged JPEG", _COPY_AGAIN)
    if header.bits != 8:
        raise _UnusableError(f"is a JPEG of {header.bits} bit")
    # In a scan, 0xFF is always followed by another byte: this marker is the end.
    if data.find(b"\xff\xd9", at) < 0:
        raise _UnusableError("is cut short", _COPY_AGAIN)
    return data, header


def _bmp(data: bytes) -> tuple[bytes, _Header]:
    """Compare the pixels that the header promises with those that are there."""
    start, size, width, height, _, bits, compression = struct.unpack_from("<IIiiHHI", data, 10)
    if size < 40:
        raise _UnusableError("is a BMP of OS/2")
    if compression not in {0, 3, 6}:
        raise _UnusableError("is a compressed BMP")
    if width < 0:
        raise _UnusableError("is a damaged BMP", _COPY_AGAIN)
    height = abs(height)  # negative: rows from the top
    stride = (width * bits + 31) // 32 * 4
    if start + stride * height > len(data):
        raise _UnusableError("is cut short", _COPY_AGAIN)
    return data, _Header(width, height, min(bits, 8))


_TIFF_SHORTS = {3: "H", 4: "I"}
_ORIENTATION = 274


def _tiff(data: bytes) -> tuple[bytes, _Header]:
    """Read the first directory (TIFF 6.0, section 2) and refuse what OpenCV would change.

    OpenCV turns the image as the orientation tag says: the tag is set to 1.
    """
    order = "<" if data.startswith(b"I") else ">"
    (start,) = struct.unpack_from(order + "I", data, 4)
    (count,) = struct.unpack_from(order + "H", data, start)
    if struct.unpack_from(order + "I", data, start + 2 + 12 * count)[0]:
        raise _UnusableError("is a TIFF of several pages", "save one page a file")
    tags: dict[int, int] = {}
    edited = bytearray(data)
    for at in range(start + 2, start + 2 + 12 * count, 12):
        tag, kind, values = struct.unpack_from(order + "HHI", data, at)
        if tag in tags:
            raise _UnusableError("is a damaged TIFF", _COPY_AGAIN)
        tags[tag] = _tiff_value(data, order, at, kind, values)
        if tag == _ORIENTATION:
            struct.pack_into(order + "HHIHH", edited, at, tag, 3, 1, 1, 0)
    return bytes(edited), _tiff_header(tags)


def _tiff_value(data: bytes, order: str, at: int, kind: int, count: int) -> int:
    """Give the first value of a tag that counts something, else 0."""
    code = _TIFF_SHORTS.get(kind)
    if code is None or not count:
        return 0
    if struct.calcsize(order + code) * count > 4:
        (at,) = struct.unpack_from(order + "I", data, at + 8)
        at -= 8
    return int(struct.unpack_from(order + code, data, at + 8)[0])


def _tiff_header(tags: dict[int, int]) -> _Header:
    bits, photometric, samples = tags.get(258, 1), tags.get(262, -1), tags.get(277, 1)
    if bits not in {1, 8, 16} or tags.get(339, 1) != 1:
        kind = {2: "signed", 3: "float"}.get(tags.get(339, 1), "")
        raise _UnusableError(f"is a TIFF of {bits} bit {kind}".rstrip())
    if photometric not in {1, 2, 3} or (photometric == 3 and bits != 8):
        # 0 is black on white, which OpenCV inverts in 8 bit and not in 16; 5 and up are CMYK etc.
        raise _UnusableError(f"is a TIFF of photometric interpretation {photometric}")
    if samples not in ({3, 4} if photometric == 2 else {1}):
        raise _UnusableError(f"is a TIFF of {samples} channels")
    return _Header(tags.get(256, 0), tags.get(257, 0), bits, premultiplied=samples == 4)


_FORMATS: dict[bytes, Callable[[bytes], tuple[bytes, _Header]]] = {
    b"\x89PNG\r\n\x1a\n": _png,
    b"\xff\xd8\xff": _jpeg,
    b"BM": _bmp,
    b"II*\0": _tiff,
    b"MM\0*": _tiff,
}


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
        raise InputError("is damaged or cut short", file=path, remedy=_COPY_AGAIN)
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


def _rgb(image: NDArray[Any], header: _Header, path: str | Path) -> NDArray[Any]:
    """Drop alpha and put the channels in RGB order."""
    if image.ndim == 2:
        return image
    if image.shape[2] not in {3, 4}:
        raise InputError(f"has {image.shape[2]} channels", file=path, remedy=_SAVE_AGAIN)
    if header.premultiplied and image.shape[2] == 4:
        opaque = np.iinfo(image.dtype).max
        if (image[:, :, 3] != opaque).any():
            raise InputError(
                "is a TIFF with transparent pixels", file=path, remedy="save it without alpha"
            )
    return np.ascontiguousarray(image[:, :, 2::-1])
