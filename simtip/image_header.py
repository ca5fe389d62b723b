"""What an image file promises, read before any of it is decoded.

A decoder would pass in silence what is refused here: a file that is cut short, a header that
promises gigabytes, a TIFF whose values OpenCV would change.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass

MAX_PARTS = 1_000_000
"""Most chunks of a PNG or segments of a JPEG."""

SAVE_AGAIN = "save it again as PNG, 8 or 16 bit, gray or RGB"
COPY_AGAIN = "copy or save it again"


class UnusableError(Exception):
    """A header says that the file is of no use."""

    def __init__(self, problem: str, remedy: str = SAVE_AGAIN) -> None:
        super().__init__(problem)
        self.remedy = remedy


@dataclass(frozen=True)
class Header:
    """What the file promises: size in px, bits per value."""

    width: int
    height: int
    bits: int
    # TIFF: OpenCV multiplies the colours by the alpha channel.
    premultiplied: bool = False


def check_header(data: bytes) -> tuple[bytes, Header]:
    """Check a file's structure; give the bytes to decode and what they promise."""
    for magic, check in _FORMATS.items():
        if data.startswith(magic):
            try:
                return check(data)
            except struct.error:  # a field lies beyond the end
                raise UnusableError("is cut short", COPY_AGAIN) from None
    raise UnusableError("is not a PNG, TIFF, JPEG or BMP image")


def _png(data: bytes) -> tuple[bytes, Header]:
    """Walk the chunks (ISO/IEC 15948, 5.3) up to IEND, checking each CRC."""
    if data[12:16] != b"IHDR":
        raise UnusableError("is a damaged PNG", COPY_AGAIN)
    width, height, bits = struct.unpack_from(">IIB", data, 16)
    view = memoryview(data)
    at = 8
    for _ in range(MAX_PARTS):
        length, name = struct.unpack_from(">I4s", data, at)
        (crc,) = struct.unpack_from(">I", data, at + 8 + length)
        if zlib.crc32(view[at + 4 : at + 8 + length]) != crc:
            raise UnusableError("is a damaged PNG: a checksum is wrong", COPY_AGAIN)
        if name == b"IEND":
            return data, Header(width, height, bits)
        at += 12 + length
    raise UnusableError("is a PNG of too many chunks")


_START_OF_FRAME = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


def _jpeg(data: bytes) -> tuple[bytes, Header]:
    """Walk the segments (ISO/IEC 10918-1, B.1.1) to the first scan; look for the end marker."""
    at, header = 2, None
    for _ in range(MAX_PARTS):
        mark, code, length = struct.unpack_from(">BBH", data, at)
        if mark != 0xFF or code == 0xDA:
            break
        if code in _START_OF_FRAME and header is None:
            bits, height, width = struct.unpack_from(">BHH", data, at + 4)
            header = Header(width, height, bits)
        at += 1 if code == 0xFF else 2 + max(length, 2)  # 0xFF: padding before a marker
    if header is None or mark != 0xFF:
        raise UnusableError("is a damaged JPEG", COPY_AGAIN)
    if header.bits != 8:
        raise UnusableError(f"is a JPEG of {header.bits} bit")
    # In a scan, 0xFF is always followed by another byte: this marker is the end.
    if data.find(b"\xff\xd9", at) < 0:
        raise UnusableError("is cut short", COPY_AGAIN)
    return data, header


def _bmp(data: bytes) -> tuple[bytes, Header]:
    """Compare the pixels that the header promises with those that are there."""
    start, size, width, height, _, bits, compression = struct.unpack_from("<IIiiHHI", data, 10)
    if size < 40:
        raise UnusableError("is a BMP of OS/2")
    if compression not in {0, 3, 6}:
        raise UnusableError("is a compressed BMP")
    if width < 0:
        raise UnusableError("is a damaged BMP", COPY_AGAIN)
    height = abs(height)  # negative: rows from the top
    stride = (width * bits + 31) // 32 * 4
    if start + stride * height > len(data):
        raise UnusableError("is cut short", COPY_AGAIN)
    return data, Header(width, height, min(bits, 8))


_TIFF_SHORTS = {3: "H", 4: "I"}
_ORIENTATION = 274


def _tiff(data: bytes) -> tuple[bytes, Header]:
    """Read the first directory (TIFF 6.0, section 2) and refuse what OpenCV would change.

    OpenCV turns the image as the orientation tag says: the tag is set to 1.
    """
    order = "<" if data.startswith(b"I") else ">"
    (start,) = struct.unpack_from(order + "I", data, 4)
    (count,) = struct.unpack_from(order + "H", data, start)
    if struct.unpack_from(order + "I", data, start + 2 + 12 * count)[0]:
        raise UnusableError("is a TIFF of several pages", "save one page a file")
    tags: dict[int, int] = {}
    edited = bytearray(data)
    for at in range(start + 2, start + 2 + 12 * count, 12):
        tag, kind, values = struct.unpack_from(order + "HHI", data, at)
        if tag in tags:
            raise UnusableError("is a damaged TIFF", COPY_AGAIN)
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


def _tiff_header(tags: dict[int, int]) -> Header:
    bits, photometric, samples = tags.get(258, 1), tags.get(262, -1), tags.get(277, 1)
    if bits not in {1, 8, 16} or tags.get(339, 1) != 1:
        kind = {2: "signed", 3: "float"}.get(tags.get(339, 1), "")
        raise UnusableError(f"is a TIFF of {bits} bit {kind}".rstrip())
    if photometric not in {1, 2, 3} or (photometric == 3 and bits != 8):
        # 0 is black on white, which OpenCV inverts in 8 bit and not in 16; 5 and up are CMYK etc.
        raise UnusableError(f"is a TIFF of photometric interpretation {photometric}")
    if samples not in ({3, 4} if photometric == 2 else {1}):
        raise UnusableError(f"is a TIFF of {samples} channels")
    return Header(tags.get(256, 0), tags.get(257, 0), bits, premultiplied=samples == 4)


_FORMATS: dict[bytes, Callable[[bytes], tuple[bytes, Header]]] = {
    b"\x89PNG\r\n\x1a\n": _png,
    b"\xff\xd8\xff": _jpeg,
    b"BM": _bmp,
    b"II*\0": _tiff,
    b"MM\0*": _tiff,
}
