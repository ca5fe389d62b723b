"""Do image files arrive pixel for pixel as stored, and is every unusable file refused in one line?

The files are built byte by byte from the format's own specification wherever OpenCV's encoder could
hide a mistake of OpenCV's decoder.
"""

import contextlib
import struct
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from simtip.errors import InputError
from simtip.image_file import read_image, write_png

SETTINGS = settings(derandomize=True, deadline=None, max_examples=40)


def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png(size, bits, colour, rows, before=b""):
    header = struct.pack(">IIBBBBB", *size, bits, colour, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + before
        + chunk(b"IDAT", pixels)
        + chunk(b"IEND", b"")
    )


def tiff(pixels, order="<", following=0, **changes):
    """A 3 x 2 TIFF; changes are ``t<tag>=values`` (SHORT) or ``t<tag>=None``."""
    tags = {256: [3], 257: [2], 258: [8], 259: [1], 262: [1], 277: [1], 278: [2]}
    tags |= {int(tag[1:]): values for tag, values in changes.items()}
    tags = {tag: ("H", values) for tag, values in tags.items() if values is not None}
    tags.setdefault(273, ("I", [8]))
    tags.setdefault(279, ("I", [len(pixels)]))
    body = pixels + b"\0" * (len(pixels) % 2)
    start = 8 + len(body)
    extra_at = start + 2 + 12 * len(tags) + 4
    entries, extra = b"", b""
    for tag in sorted(tags):
        code, values = tags[tag]
        packed = struct.pack(f"{order}{len(values)}{code}", *values)
        if len(packed) > 4:
            value = struct.pack(order + "I", extra_at + len(extra))
            extra += packed
        else:
            value = packed.ljust(4, b"\0")
        kind = {"H": 3, "I": 4}[code]
        entries += struct.pack(order + "HHI", tag, kind, len(values)) + value
    return (
        {"<": b"II*\0", ">": b"MM\0*"}[order]
        + struct.pack(order + "I", start)
        + body
        + struct.pack(order + "H", len(tags))
        + entries
        + struct.pack(order + "I", following)
        + extra
    )


def bmp(rows_rgb, *, top_down=False):
    height, width = rows_rgb.shape[:2]
    rows = rows_rgb if top_down else rows_rgb[::-1]
    stride = (3 * width + 3) // 4 * 4
    pixels = b"".join(row[:, ::-1].tobytes().ljust(stride, b"\0") for row in rows)
    info = struct.pack(
        "<IiiHHIIiiII", 40, width, -height if top_down else height, 1, 24, 0, 0, 0, 0, 0, 0
    )
    return b"BM" + struct.pack("<IHHI", 54 + len(pixels), 0, 0, 54) + info + pixels


def read(tmp_path, data, name="image.bin"):
    path = tmp_path / name
    path.write_bytes(data)
    return read_image(path)


PALETTE = chunk(b"PLTE", bytes([255, 0, 0, 1, 2, 3]))
RGB6 = bytes(range(18))
RGB6_PIXELS = np.arange(18, dtype=np.uint8).reshape(2, 3, 3)
SIX = np.array([[16, 32, 48], [64, 80, 96]], np.uint8)
SIX16 = np.array([[1000, 2000, 3000], [4000, 5000, 60000]], np.uint16)
EXIF = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"

STORED = {
    "png gray": (png((2, 2), 8, 0, [b"\1\2", b"\3\xff"]), [[1, 2], [3, 255]]),
    "png gray 16": (png((2, 1), 16, 0, [b"\1\2\xff\xfe"]), [[258, 65534]]),
    "png 1 bit": (png((3, 1), 1, 0, [b"\xa0"]), [[255, 0, 255]]),
    "png 2 bit": (png((4, 1), 2, 0, [b"\x1b"]), [[0, 85, 170, 255]]),
    "png rgb": (png((2, 1), 8, 2, [b"\1\2\3\4\5\6"]), [[[1, 2, 3], [4, 5, 6]]]),
    "png rgb 16": (png((1, 1), 16, 2, [b"\1\0\2\0\3\0"]), [[[256, 512, 768]]]),
    "png rgba": (png((2, 1), 8, 6, [b"\1\2\3\0\4\5\6\x80"]), [[[1, 2, 3], [4, 5, 6]]]),
    "png rgba 16": (png((1, 1), 16, 6, [b"\1\0\2\0\3\0\0\1"]), [[[256, 512, 768]]]),
    "png gray alpha": (png((2, 1), 8, 4, [b"\5\0\7\x08"]), [[[5, 5, 5], [7, 7, 7]]]),
    "png palette": (png((2, 1), 8, 3, [b"\0\1"], PALETTE), [[[255, 0, 0], [1, 2, 3]]]),
    "png palette alpha": (
        png((2, 1), 8, 3, [b"\0\1"], PALETTE + chunk(b"tRNS", b"\0\x7f")),
        [[[255, 0, 0], [1, 2, 3]]],
    ),
    "png gamma": (
        png((2, 1), 8, 0, [b"\5\x80"], chunk(b"gAMA", struct.pack(">I", 100000))),
        [[5, 128]],
    ),
    "png exif turned": (png((2, 1), 8, 0, [b"\5\x80"], chunk(b"eXIf", EXIF)), [[5, 128]]),
    "png bad profile": (png((2, 1), 8, 0, [b"\5\x80"], chunk(b"iCCP", b"a\0\0z")), [[5, 128]]),
    "tiff": (tiff(SIX.tobytes()), SIX),
    "tiff big-endian": (tiff(SIX.tobytes(), ">"), SIX),
    "tiff 1 bit": (tiff(b"\xa0\x40", t258=[1]), [[255, 0, 255], [0, 255, 0]]),
    "tiff 16": (tiff(SIX16.tobytes(), t258=[16]), SIX16),
    "tiff 16 big-endian": (tiff(SIX16.astype(">u2").tobytes(), ">", t258=[16]), SIX16),
    "tiff rgb": (tiff(RGB6, t258=[8] * 3, t262=[2], t277=[3]), RGB6_PIXELS),
    "tiff rgb 16": (
        tiff(RGB6_PIXELS.astype("<u2").tobytes(), t258=[16] * 3, t262=[2], t277=[3]),
        RGB6_PIXELS.astype(np.uint16),
    ),
    "tiff opaque alpha": (
        tiff(
            np.dstack([RGB6_PIXELS, np.full((2, 3), 255, np.uint8)]).tobytes(),
            t258=[8] * 4,
            t262=[2],
            t277=[4],
            t338=[2],
        ),
        RGB6_PIXELS,
    ),
    "tiff palette": (
        tiff(bytes([0, 1, 2, 0, 1, 2]), t262=[3], t320=[257 * v for v in range(256)] * 3),
        [[[0] * 3, [1] * 3, [2] * 3]] * 2,
    ),
    **{f"tiff turned {o}": (tiff(SIX.tobytes(), t274=[o]), SIX) for o in range(2, 9)},
    "tiff 16 turned": (tiff(SIX16.tobytes(), t258=[16], t274=[6]), SIX16),
    "bmp": (bmp(RGB6_PIXELS), RGB6_PIXELS),
    "bmp from the top": (bmp(RGB6_PIXELS, top_down=True), RGB6_PIXELS),
}


@pytest.mark.parametrize("name", STORED)
def test_pixels_are_those_stored(tmp_path, name, capfd):
    data, expected = STORED[name]
    found = read(tmp_path, data)
    np.testing.assert_array_equal(found, np.asarray(expected))
    assert found.dtype == (np.uint16 if "16" in name else np.uint8)
    assert found.flags.c_contiguous
    assert capfd.readouterr() == ("", "")


def smooth(height=48, width=64):
    v, u = np.mgrid[:height, :width]
    return np.dstack([2 * u, 3 * v, u + v]).astype(np.uint8)


def with_exif(jpeg):
    body = b"Exif\0\0" + EXIF
    return jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + jpeg[2:]


def encoded(extension, image, *options):
    return cv2.imencode(extension, image, options)[1].tobytes()


def test_a_jpeg_is_rgb_and_not_turned_by_exif(tmp_path):
    image = smooth()
    data = encoded(".jpg", image[:, :, ::-1], cv2.IMWRITE_JPEG_QUALITY, 100)
    found = read(tmp_path, with_exif(data))
    assert found.shape == image.shape
    assert np.abs(found.astype(int) - image).max() <= 6
    gray = read(tmp_path, encoded(".jpg", image[:, :, 0]))
    assert gray.shape == (48, 64)
    progressive = read(tmp_path, encoded(".jpg", image, cv2.IMWRITE_JPEG_PROGRESSIVE, 1))
    assert progressive.shape == image.shape
    assert read(tmp_path, data + b"\0" * 100).shape == image.shape


@pytest.mark.parametrize("extension", [".png", ".tif", ".bmp"])
@pytest.mark.parametrize("shape", [(7, 5), (7, 5, 3), (1, 1), (1, 300, 3)])
def test_what_opencv_encodes_without_loss_is_read_back(tmp_path, extension, shape):
    image = np.random.default_rng(0).integers(0, 256, shape, np.uint8)
    bgr = image[..., ::-1] if image.ndim == 3 else image
    np.testing.assert_array_equal(read(tmp_path, encoded(extension, bgr)), image)


@pytest.mark.parametrize("compression", [1, 5, 8, 32773])
def test_compressed_tiffs_are_read_and_refused_when_cut(tmp_path, compression):
    image = np.random.default_rng(0).integers(0, 65536, (40, 50), np.uint16)
    data = encoded(".tif", image, cv2.IMWRITE_TIFF_COMPRESSION, compression)
    np.testing.assert_array_equal(read(tmp_path, data), image)
    for end in range(0, len(data), 997):
        with pytest.raises(InputError):
            read(tmp_path, data[: end or 1])


def test_names_in_any_script_work(tmp_path):
    path = tmp_path / "Nadel игла 針 é.png"
    write_png(path, smooth())
    np.testing.assert_array_equal(read_image(path), smooth())


@SETTINGS
@given(
    st.sampled_from([np.uint8, np.uint16]).flatmap(
        lambda dtype: arrays(
            dtype,
            array_shapes(min_dims=2, max_dims=2, max_side=9)
            | array_shapes(min_dims=2, max_dims=2, max_side=9).map(lambda s: (*s, 3)),
        )
    )
)
def test_any_image_round_trips_as_png(tmp_path_factory, image):
    path = tmp_path_factory.getbasetemp() / "image.png"
    write_png(path, image)
    found = read_image(path)
    np.testing.assert_array_equal(found, image)
    assert found.dtype == image.dtype


def test_png_colours_are_rgb_on_disk(tmp_path):
    write_png(tmp_path / "a.png", np.array([[[1, 2, 3]]], np.uint8))
    np.testing.assert_array_equal(cv2.imread(str(tmp_path / "a.png")), [[[3, 2, 1]]])


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((2, 2), np.float64),
        np.zeros((2, 2), bool),
        np.zeros((2, 2, 4), np.uint8),
        np.zeros((2,), np.uint8),
        np.zeros((0, 2), np.uint8),
    ],
)
def test_what_is_no_image_is_not_written(tmp_path, image):
    with pytest.raises(ValueError, match=r"uint8 or uint16|is \(H, W\)"):
        write_png(tmp_path / "a.png", image)
    assert list(tmp_path.iterdir()) == []


PNG = png((64, 48), 8, 2, [row.tobytes() for row in smooth()])
JPEG = encoded(".jpg", smooth())
BMP = bmp(smooth())
HUGE = (200_000, 200_000)
JPEG_SIZE = JPEG.index(b"\xff\xc0") + 5


def huge_jpeg():
    return JPEG[:JPEG_SIZE] + struct.pack(">HH", 60000, 60000) + JPEG[JPEG_SIZE + 4 :]


def huge_bmp():
    return BMP[:18] + struct.pack("<ii", 1 << 30, 1 << 30) + BMP[26:]


REFUSED = {
    "empty": (b"", "is empty"),
    "text": (b"hello", "not a PNG, TIFF, JPEG or BMP"),
    "gif": (b"GIF89a" + bytes(50), "not a PNG, TIFF, JPEG or BMP"),
    "png, only the signature": (PNG[:8], "cut short|damaged"),
    "png, half": (PNG[: len(PNG) // 2], "cut short"),
    "png, no end": (PNG[:-12], "cut short"),
    "png, end cut": (PNG[:-1], "cut short"),
    "png, wrong checksum": (PNG[:60] + bytes([PNG[60] ^ 1]) + PNG[61:], "checksum"),
    "png, too few rows": (png((64, 48), 8, 2, [row.tobytes() for row in smooth(9)]), "damaged"),
    "png, bad filter": (png((3, 2), 8, 0, [b"abc\x09", b"de"]), "damaged"),
    "png, no width": (png((0, 1), 8, 0, [b""]), "no pixels"),
    "png, huge": (png(HUGE, 8, 0, [b""]), "200000 x 200000"),
    "png, no header": (b"\x89PNG\r\n\x1a\n" + chunk(b"IEND", b""), "damaged"),
    "png, long chunk": (PNG[:33] + b"\xff\xff\xff\xff" + PNG[37:], "cut short"),
    "jpeg, start only": (JPEG[:3], "cut short"),
    "jpeg, half": (JPEG[: len(JPEG) // 2], "cut short"),
    "jpeg, no end marker": (JPEG[:-2], "cut short"),
    "jpeg, half with end marker": (JPEG[:-200] + b"\xff\xd9", "damaged"),
    "jpeg, hole": (JPEG[:-300] + JPEG[-200:], "damaged"),
    "jpeg, no frame": (JPEG[:2] + JPEG[JPEG.index(b"\xff\xda") :], "damaged"),
    "jpeg, thumbnail ends, file does not": (with_exif(JPEG)[:100], "cut short"),
    "jpeg, huge": (huge_jpeg(), "60000 x 60000"),
    "jpeg, 12 bit": (JPEG[: JPEG_SIZE - 1] + b"\x0c" + JPEG[JPEG_SIZE:], "12 bit"),
    "bmp, header only": (BMP[:54], "cut short"),
    "bmp, half header": (BMP[:20], "cut short"),
    "bmp, last byte cut": (BMP[:-1], "cut short"),
    "bmp, huge": (huge_bmp(), "cut short"),
    "bmp, run lengths": (BMP[:30] + struct.pack("<I", 1) + BMP[34:], "compressed"),
    "bmp, OS/2": (BMP[:14] + struct.pack("<I", 12) + BMP[18:], "OS/2"),
    "tiff, start only": (b"II*\0", "cut short"),
    "tiff, no directory": (b"II*\0" + struct.pack("<I", 9999), "cut short"),
    "tiff, cut": (tiff(SIX.tobytes())[:-20], "cut short"),
    "tiff, big": (b"II+\0" + bytes(40), "not a PNG, TIFF"),
    "tiff, float": (tiff(bytes(24), t258=[32], t339=[3]), "32 bit float"),
    "tiff, half float": (tiff(bytes(12), t258=[16], t339=[3]), "16 bit float"),
    "tiff, 32 bit": (tiff(bytes(24), t258=[32]), "32 bit"),
    "tiff, 12 bit": (tiff(bytes(10), t258=[12]), "12 bit"),
    "tiff, signed": (tiff(bytes(12), t258=[16], t339=[2]), "16 bit signed"),
    "tiff, black on white": (tiff(SIX16.tobytes(), t258=[16], t262=[0]), "interpretation 0"),
    "tiff, cmyk": (tiff(bytes(24), t258=[8] * 4, t262=[5], t277=[4]), "interpretation 5"),
    "tiff, gray alpha": (tiff(bytes(12), t258=[8] * 2, t277=[2], t338=[2]), "2 channels"),
    "tiff, see-through": (
        tiff(bytes(24), t258=[8] * 4, t262=[2], t277=[4], t338=[2]),
        "transparent",
    ),
    "tiff, 16 bit palette": (tiff(bytes(12), t258=[16], t262=[3]), "interpretation 3"),
    "tiff, strips missing": (tiff(SIX.tobytes(), t257=[200], t278=[200]), "damaged|cut short"),
    "tiff, no size": (tiff(SIX.tobytes(), t256=None), "no pixels"),
    "tiff, huge": (tiff(SIX.tobytes(), t256=[60000], t257=[60000]), "60000 x 60000"),
    "tiff, pages": (tiff(SIX.tobytes(), following=8), "several pages"),
    "tiff, endless pages": (tiff(SIX.tobytes(), following=14), "several pages"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_an_unusable_file_is_refused_in_one_line(tmp_path, name, capfd):
    data, pattern = REFUSED[name]
    with pytest.raises(InputError, match=pattern) as caught:
        read(tmp_path, data)
    message = str(caught.value)
    assert message.startswith(str(tmp_path / "image.bin"))
    assert caught.value.remedy
    assert "\n" not in message
    assert capfd.readouterr() == ("", "")


def test_missing_files_and_folders_are_refused(tmp_path):
    for path, pattern in {
        tmp_path: "is a folder",
        tmp_path / "none.png": "no such file",
        "/dev/zero": "not a regular file",
    }.items():
        with pytest.raises(InputError, match=pattern):
            read_image(path)


def test_a_file_that_cannot_be_written_leaves_nothing(tmp_path):
    file = tmp_path / "file"
    file.write_text("mine")
    for path in (file / "a.png", tmp_path / "none" / "a.png", tmp_path, "/dev/null", "a\0b"):
        with pytest.raises(InputError):
            write_png(path, smooth())
    assert file.read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_an_interrupted_write_keeps_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    write_png(path, smooth())
    old = path.read_bytes()

    def stop(*_args):
        raise KeyboardInterrupt

    monkeypatch.setattr("simtip.output_folder.Path.replace", stop)
    with pytest.raises(KeyboardInterrupt):
        write_png(path, smooth(9, 9))
    assert path.read_bytes() == old
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.parametrize(
    "whole", [PNG, JPEG, BMP, tiff(SIX.tobytes())], ids=["png", "jpeg", "bmp", "tiff"]
)
def test_no_beginning_of_a_file_passes_for_the_whole(tmp_path, whole):
    ends = sorted({*range(1, min(len(whole), 60)), *range(1, len(whole), 211), len(whole) - 1})
    for end in ends:
        if whole.startswith(b"II") and end >= len(whole) - 4:
            continue  # nothing but the empty link to a next page is cut off
        with pytest.raises(InputError):
            read(tmp_path, whole[:end])


@SETTINGS
@given(st.sampled_from([PNG, JPEG, BMP, tiff(SIX.tobytes())]), st.data())
def test_no_other_error_escapes_from_a_garbled_file(tmp_path_factory, whole, data):
    garbled = bytearray(whole)
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, min(len(garbled), 400) - 1))
        garbled[at] = data.draw(st.sampled_from([0, 1, 0x7F, 0x80, 0xFF]))
    path = tmp_path_factory.getbasetemp() / "garbled"
    path.write_bytes(garbled)
    with contextlib.suppress(InputError):
        assert read_image(path).dtype in (np.uint8, np.uint16)
