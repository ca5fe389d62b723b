"""Left and right images by their names, as people name them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from simtip.calibration_images import find_pairs
from simtip.errors import InputError


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Make empty files of some names; pairing does not look inside."""
    monkeypatch.chdir(tmp_path)

    def make(*names: str) -> Path:
        for name in names:
            file = tmp_path / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.touch()
        return tmp_path

    return make


def paired(*images: str) -> list[tuple[str, str]]:
    return [(os.path.relpath(p.left), os.path.relpath(p.right)) for p in find_pairs(images).pairs]


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("left_01.png", "right_01.png"),
        ("left01.jpg", "right01.jpg"),
        ("left-1.tif", "right-1.tif"),
        ("LEFT_1.PNG", "RIGHT_1.PNG"),
        ("Left 3.bmp", "right_03.jpeg"),
        ("left.png", "right.png"),
        ("leftcamera7.png", "rightcamera7.png"),
        ("cam_left_12.png", "cam_right_12.png"),
        ("12-left.tiff", "12-right.tiff"),
        ("left/a7.png", "right/a7.png"),
        ("Left/img_left_2.png", "RIGHT/img_right_2.png"),
    ],
)
def test_a_folder_gives_its_pair(left, right, folder):
    assert paired(str(folder(left, right, "truth.json", "notes.txt"))) == [(left, right)]


def test_ten_comes_after_two_and_leading_zeros_do_not_matter(folder):
    where = folder("left10.png", "left2.png", "left1.png", "right01.png", "right002.png")
    folder("right10.png")
    pairs = find_pairs([str(where)]).pairs
    assert [pair.name for pair in pairs] == ["1", "2", "10"]
    assert [pair.right.name for pair in pairs] == ["right01.png", "right002.png", "right10.png"]


def test_other_pictures_of_a_pair_do_not_count(folder):
    where = folder(
        "left_1.png", "right_1.png", "overlay_left_1.png", ".left_2.png", "._right_1.png"
    )
    assert paired(str(where)) == [("left_1.png", "right_1.png")]


def test_an_image_alone_is_named(folder):
    found = find_pairs([str(folder("left1.png", "left2.png", "right2.png", "right3.png"))])
    assert [pair.name for pair in found.pairs] == ["2"]
    assert [file.name for file in found.unpaired] == ["left1.png", "right3.png"]


@pytest.mark.parametrize(
    ("patterns", "files"),
    [
        (("a/*_L.png", "a/*_R.png"), ("a/07_L.png", "a/07_R.png")),
        (("cam0/*.png", "cam1/*.png"), ("cam0/frame7.png", "cam1/frame7.png")),
        (("cam0", "cam1"), ("cam0/7.png", "cam1/7.jpg")),
        (("left*", "right*"), ("left7.png", "right7.jpg")),
        (("./left*.png", "right?.png"), ("left7.png", "right7.png")),
        (("l[0-9]*.png", "r[0-9]*.png"), ("l7.png", "r7.png")),
        (("*/left/7.png", "*/right/7.png"), ("x/left/7.png", "x/right/7.png")),
    ],
)
def test_two_patterns_pair_what_their_wildcards_stand_for(patterns, files, folder):
    folder(*files, "other.png")
    assert paired(*patterns) == [files]


def test_an_absolute_pattern_is_one_too(folder):
    where = folder("left7.png", "right7.png")
    assert paired(f"{where}/left*.png", f"{where}/right*.png") == [("left7.png", "right7.png")]


def test_a_shell_may_have_expanded_the_patterns(folder):
    folder("left1.png", "left2.png", "right1.png", "right2.png")
    expected = [("left1.png", "right1.png"), ("left2.png", "right2.png")]
    assert paired("left1.png", "left2.png", "right1.png", "right2.png") == expected


@pytest.mark.parametrize(
    ("files", "images", "said"),
    [
        (["left1.png", "left2.png"], ["."], r"2 images, but none of the right camera; name them"),
        (["a.png"], ["."], r"no images that are named left and right, and 1 others"),
        ([], ["nowhere"], "nowhere: is no folder"),
        (["left1.png"], ["left*"], r"left\*: is no folder; .*pattern for each"),
        (["left1.png"], ["left*.png", "right*.png"], r"right\*.png: no images"),
        (["left1.png", "right2.png"], ["."], r"fits .*left1.png, right2.png"),
        (["left1.png", "left01.jpg", "right1.png"], ["."], r"left1.png: shows the same .*left01"),
        (["c/1.png"], ["c", "c"], "is both the left and the right image"),
        (["a1.png", "a2.png", "a3.png"], ["a1.png", "a2.png", "a3.png"], "named left or right"),
    ],
)
def test_what_makes_no_pairs_is_named(files, images, said, folder):
    folder(*files)
    with pytest.raises(InputError, match=said):
        find_pairs(images)
