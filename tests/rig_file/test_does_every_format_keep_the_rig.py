"""Does a rig survive being written and read, in every format, to rounding?"""

import numpy as np
import pytest
from hypothesis import given
from rig_examples import SETTINGS, assert_same_rig, paper_like, rigs

from simtip.errors import InputError
from simtip.rig_file import FORMATS, read_rig, rig_files, rig_text, write_rig

NAMES = {
    "opencv": "rig.yaml",
    "opencv-xml": "rig.xml",
    "json": "rig.json",
    "ros": "pair",
    "kalibr": "camchain.yaml",
}
CARRIED = {
    "opencv": [0, 4, 5, 8, 12, 14],
    "opencv-xml": [0, 4, 5, 8, 12, 14],
    "json": [0, 4, 5, 8, 12, 14],
    "ros": [0, 4, 5, 8],
    "kalibr": [0, 4],
}


def test_every_format_is_tried():
    assert set(NAMES) == set(CARRIED) == set(FORMATS)


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMATS)
def test_any_rig_comes_back(tmp_path_factory, form):
    path = tmp_path_factory.mktemp("any") / NAMES[form]

    @SETTINGS
    @given(rigs(CARRIED[form]))
    def comes_back(rig):
        write_rig(path, rig, form)
        assert_same_rig(read_rig(path), rig)

    comes_back()


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("count", [0, 4, 5, 8, 12, 14])
def test_coefficients_are_kept_or_refused_but_never_dropped(tmp_path, form, count):
    rig = paper_like(count)
    path = tmp_path / NAMES[form]
    if count in CARRIED[form]:
        write_rig(path, rig, form)
        assert_same_rig(read_rig(path), rig)
        return
    with pytest.raises(InputError, match=rf"has {count} coefficients.*json, which hold") as caught:
        write_rig(path, rig, form)
    assert caught.value.field == "left.distortion"
    assert caught.value.file == str(path)
    assert list(tmp_path.iterdir()) == []


def test_zeros_beyond_what_a_format_holds_are_no_obstacle(tmp_path):
    rig = paper_like(4)
    longer = paper_like(4)
    for camera in (longer.left, longer.right):
        object.__setattr__(camera, "distortion", (*camera.distortion, *[0.0] * 10))
    for form in ("ros", "kalibr"):
        write_rig(tmp_path / NAMES[form], longer, form)
        assert_same_rig(read_rig(tmp_path / NAMES[form]), rig)


def test_a_chain_through_all_formats_ends_where_it_began(tmp_path):
    rig = first = paper_like(4, right_size=(640, 480))
    for form in FORMATS:
        write_rig(tmp_path / NAMES[form], rig, form)
        rig = read_rig(tmp_path / NAMES[form])
    assert_same_rig(rig, first)


@pytest.mark.parametrize("form", FORMATS)
def test_the_files_state_their_convention_and_units(tmp_path, form):
    write_rig(tmp_path / NAMES[form], paper_like(), form)
    for file in rig_files(tmp_path / NAMES[form], form):
        text = file.read_text()
        pose = "p_left = R p_right + T_mm" if form == "json" else "p_right = R p_left + T"
        assert pose in text
        assert ("METRES" if form in {"ros", "kalibr"} else "in mm") in text
        assert "x right, y down, z forward" in text
        assert "(0, 0) is the centre of the" in text
        assert "left" in text


@pytest.mark.parametrize("form", FORMATS)
def test_the_text_is_that_of_the_file(tmp_path, form):
    if form == "ros":
        with pytest.raises(InputError, match="pair of files"):
            rig_text(paper_like(), form)
        return
    write_rig(tmp_path / NAMES[form], paper_like(), form)
    assert (tmp_path / NAMES[form]).read_text() == rig_text(paper_like(), form)


@pytest.mark.parametrize(
    ("name", "begins"),
    [("a.yml", "%YAML"), ("a.YAML", "%YAML"), ("a.xml", "<?xml"), ("a.json", "{")],
)
def test_the_ending_says_the_format(tmp_path, name, begins):
    write_rig(tmp_path / name, paper_like(14))
    assert (tmp_path / name).read_text().startswith(begins)
    assert_same_rig(read_rig(tmp_path / name), paper_like(14))


@pytest.mark.parametrize(
    ("name", "form", "fragment"),
    [
        ("rig", None, "end it in .yaml, .xml or .json"),
        ("rig.txt", None, "'.txt'"),
        ("rig.json", "opencv", "end it in .yaml or .yml"),
        ("rig.yaml", "json", "end it in .json"),
        ("rig.xml", "kalibr", "'.xml'"),
        ("pair.json", "ros", "'.json'"),
        ("rig.yaml", "ros", "left and right"),
        ("rig.yaml", "cahvor", "choose opencv, opencv-xml, json, ros, kalibr"),
        ("no/rig.yaml", None, "cannot be written"),
        ("no/pair", "ros", "cannot be made"),
    ],
)
def test_names_that_do_not_suit_the_format_are_refused(tmp_path, name, form, fragment):
    with pytest.raises(InputError, match=fragment):
        write_rig(tmp_path / name, paper_like(), form)
    assert list(tmp_path.iterdir()) == []


def test_what_a_file_holds_says_what_it_is_not_its_name(tmp_path):
    for form in ("opencv", "opencv-xml", "json", "kalibr"):
        path = tmp_path / "rig.dat"
        path.write_text(rig_text(paper_like(), form))
        assert_same_rig(read_rig(path), paper_like())


@pytest.mark.parametrize("form", ["ros", "kalibr"])
@pytest.mark.parametrize("T_mm", [[-0.5, 0, 0], [-25_000.0, 0, 0]])
def test_a_baseline_that_would_not_be_read_is_not_written(tmp_path, form, T_mm):
    with pytest.raises(InputError, match=r"baseline is .* mm"):
        write_rig(tmp_path / NAMES[form], paper_like(T_mm=T_mm), form)


def test_kalibr_takes_no_principal_point_outside_the_image(tmp_path):
    rig = paper_like()
    beyond = type(rig)(rig.left, rig.right.cropped(1000, 0, 64, 48), rig.T_lr)
    with pytest.raises(InputError, match=r"right.K.*-64.12.*none below 0"):
        write_rig(tmp_path / "camchain.yaml", beyond, "kalibr")


def test_small_turns_are_kept_as_exactly_as_large_ones(tmp_path):
    # cv2.stereoRectify takes a turn of 1e-6 rad for none.
    turn = np.array([[1, -1e-6, 0], [1e-6, 1, 0], [0, 0, 1]])
    rig = paper_like(R=turn, T_mm=[-72.0, 0, 0])
    write_rig(tmp_path / "pair", rig, "ros")
    found = read_rig(tmp_path / "pair").T_lr.R
    assert abs(found[0, 1] - 1e-6) < 1e-15
