"""The same seed: the same bytes, from another process, too. Another seed: other noise."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
from command_line import in_a_process

pytestmark = pytest.mark.slow
IMAGES = ("left.png", "right.png", "left_mask.png", "right_mask.png")


def images(folder):
    return {name: (folder / name).read_bytes() for name in IMAGES}


def run(ran, out, *more):
    done = in_a_process("run", str(ran.bench / "scene.yaml"), "-o", "out", "--json", *more, cwd=out)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), out / "out"


def test_another_process_gives_the_same_bytes(ran, tmp_path):
    result, folder = run(ran, tmp_path)
    assert images(folder) == images(ran.folder)
    assert result | {"timings_s": None} == ran.printed | {"timings_s": None}


@pytest.mark.parametrize("side", ["left", "right"])
def test_another_seed_has_noise_of_its_own(side, ran, tmp_path):
    """Two independent exposures of one plain background: the variances of EMVA 1288 add up.

    Noise that did not follow the seed would cancel in the difference.
    """
    _, other = run(ran, tmp_path, "--seed", "11")
    first, second = (
        cv2.imread(str(folder / f"{side}.png"), cv2.IMREAD_UNCHANGED).astype(float)
        for folder in (ran.folder, other)
    )
    background = cv2.imread(str(other / f"{side}_mask.png"), cv2.IMREAD_UNCHANGED) == 0
    difference, level = (second - first)[background], first[background].mean()
    gain, read_noise = 0.0255, 5  # the sensor's defaults
    variance = gain * level + (gain * read_noise) ** 2 + 1 / 12
    assert difference.size > 5000
    # One standard error is about 1 %; rendering adds a little noise of its own.
    assert np.var(difference) == pytest.approx(2 * variance, rel=0.15)


def test_the_saved_scene_gives_the_same_bytes(ran, tmp_path):
    """With --seed, the folder's scene holds the seed that was used."""
    _, first = run(ran, tmp_path, "--seed", "11")
    done = in_a_process("render", str(first / "scene.yaml"), "-o", "again", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert images(tmp_path / "again") == images(first)
    assert images(first)["left.png"] != images(ran.folder)["left.png"]
    assert images(first)["right.png"] != images(ran.folder)["right.png"]
