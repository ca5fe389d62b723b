"""Does a program get the pixels that simtip has?"""

from __future__ import annotations

import shutil

import cv2
import numpy as np
import pytest
from programs import program

from simtip import detect
from simtip.image_file import read_image

rng = np.random.default_rng(5)
IMAGES = {
    "8-bit gray": rng.integers(0, 256, (7, 5), np.uint8),
    "16-bit gray": rng.integers(0, 65536, (7, 5), np.uint16),
    "8-bit colour": rng.integers(0, 256, (7, 5, 3), np.uint8),
    "16-bit colour": rng.integers(0, 65536, (7, 5, 3), np.uint16),
    "strided": rng.integers(0, 65536, (14, 10, 3), np.uint16)[::2, ::-2],
    "one pixel": np.array([[200]], np.uint8),
}


@pytest.fixture
def handed(tmp_path):
    """Call a program that keeps a copy of what it gets; give the copy."""

    def over(image, image_format):
        kept = tmp_path / f"kept.{image_format}"
        body = (
            f"open({str(kept)!r}, 'wb').write(open(sys.argv[1], 'rb').read())\n"
            "print(json.dumps({'reason': ' '.join(sys.argv[1:])}))"
        )
        reference = program(tmp_path, body, "{image} --same {image}", name="pro gram \u00fc.py")
        before = image.copy()
        o = detect.configure(reference, {"image_format": image_format})(image)
        assert np.array_equal(image, before)
        first, again = o.reason.split(" --same ")
        assert first == again
        assert first.startswith("/") or first[1] == ":"  # never taken for an option
        return kept

    return over


@pytest.mark.parametrize("image", IMAGES.values(), ids=IMAGES)
def test_a_png_holds_every_value(image, handed):
    stored = read_image(handed(image, "png"))
    assert stored.dtype == image.dtype
    assert np.array_equal(stored, image)


@pytest.mark.parametrize("image", IMAGES.values(), ids=IMAGES)
def test_a_pgm_holds_the_gray_values(image, handed):
    stored = cv2.imread(str(handed(image, "pgm")), cv2.IMREAD_UNCHANGED)
    assert stored.dtype == image.dtype
    gray = image if image.ndim == 2 else image @ np.array([0.299, 0.587, 0.114])
    assert np.abs(stored - gray).max() <= (0 if image.ndim == 2 else 0.5 + 1e-9)


@pytest.mark.parametrize("name", ["a b.png", "-o x.png", "\u6a21 {image} '\".png", "--json"])
def test_any_name_of_a_file_will_do(name, tmp_path, monkeypatch, ask):
    """simtip, not the program, opens the user's file."""
    monkeypatch.chdir(tmp_path)
    cv2.imwrite("plain.png", IMAGES["8-bit gray"])
    shutil.move("plain.png", name)
    reference = program(tmp_path, "print('[1, 2]')")
    answer = ask("detect", "--detector", reference, "--json", "--", name)
    assert (answer.code, answer.err) == (0, "")
    assert '"tip_px": [1.0, 2.0]' in answer.out
