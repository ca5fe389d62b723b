"""`detect`, and the regions of `measure`: pixels of the whole image, one line for what is wrong."""

from __future__ import annotations

import json
import sys

import cv2
import numpy as np
import pytest
from programs import program

from simtip import detect
from simtip.camera import Camera, StereoRig
from simtip.detect.region import Region, parse_region, within
from simtip.errors import InputError
from simtip.image_file import read_image
from simtip.measure import measure_pair
from simtip.rig_file import write_rig

AREA = ("--set", "min_area_px=100")
KEYS = ["image", "status", "reason", "tip_px", "axis", "covariance_px", "confidence", "time_s"]


def needle(u=60, end=90):
    image = np.full((120, 160), 200, np.uint8)
    image[:end, u - 6 : u + 7] = 40
    return image


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other").mkdir()
    cv2.imwrite("a.png", needle())
    cv2.imwrite("other/a.png", needle(100, 70))
    cv2.imwrite("deep.png", needle().astype(np.uint16) * 16)
    cv2.imwrite("colour.jpg", np.dstack([needle()] * 3), [cv2.IMWRITE_JPEG_QUALITY, 98])
    cv2.imwrite("blank.png", np.full((50, 40), 200, np.uint8))
    return tmp_path


def items(answer):
    assert (answer.code, answer.err) == (0, "")
    return json.loads(answer.out)


def test_a_list_with_an_item_an_image(ask):
    found = items(ask("detect", "a.png", "other/a.png", "blank.png", "--json", *AREA))
    assert [item["image"] for item in found] == ["a.png", "other/a.png", "blank.png"]
    assert [list(item) for item in found] == [KEYS] * 3
    assert [item["status"] for item in found] == ["ok", "ok", "nothing_darker_than_threshold"]
    assert found[0]["tip_px"] == [60, 89]
    assert found[1]["tip_px"] == [100, 69]
    assert found[0]["axis"] == pytest.approx([0, -1], abs=1e-6)
    assert found[0]["covariance_px"] is found[0]["confidence"] is found[2]["tip_px"] is None
    assert "T = 105" in found[2]["reason"]
    assert all(item["time_s"] > 0 for item in found)


def test_a_table_with_the_reasons_below(ask):
    answer = ask("detect", "a.png", "blank.png", *AREA)
    assert (answer.code, answer.err) == (0, "")
    assert "89.00" in answer.out
    assert "blank.png: no pixel is darker than T = 105" in answer.out


@pytest.mark.parametrize("roi", ["0,0,160,120", "40,30,50,80", "50,5,21,115"])
@pytest.mark.parametrize("name", ["a.png", "colour.jpg"])
def test_a_region_moves_no_tip(roi, name, ask):
    whole = items(ask("detect", name, "--json", *AREA))[0]
    part = items(ask("detect", name, "--json", "--roi", roi, *AREA))[0]
    assert whole["status"] == "ok"
    assert part["tip_px"] == whole["tip_px"]


def test_a_region_hides_what_lies_outside(ask):
    item = items(ask("detect", "a.png", "--json", "--roi", "80,0,80,120"))[0]
    assert item["status"] == "nothing_darker_than_threshold"
    assert item["reason"].endswith("[within the region 80,0,80,120]")


BAD_REGIONS = ["0,0,161,10", "0,0,10,121", "150,0,20,10", "-1,0,5,5", "0,0,0,5", "0,0,5", "a,b,c,d"]


@pytest.mark.parametrize("roi", [*BAD_REGIONS, "0,0,-5,5", "1.5,0,5,5", "", "9" * 5000 + ",0,1,1"])
def test_a_region_that_is_none_is_refused(roi, ask):
    answer = ask("detect", "a.png", f"--roi={roi}")
    assert (answer.code, answer.out) == (2, "")
    assert "--roi: " in answer.err
    assert answer.err.count("\n") == 1


def test_every_image_has_to_hold_the_region(ask):
    answer = ask("detect", "a.png", "blank.png", "--roi", "0,0,100,100")
    assert answer.err.startswith("simtip: blank.png: --roi: 0,0,100,100 reaches outside")


def test_a_bad_image_is_refused_before_any_work(ask, folder):
    reference = program(folder, "open('mark', 'w').close()\nprint('[1, 1]')")
    (folder / "text.png").write_text("no picture")
    for bad in ("none.png", "text.png", "other"):
        answer = ask("detect", "a.png", bad, "--detector", reference, "--overlay", "pictures")
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.startswith(f"simtip: {bad}: ")
    assert not (folder / "mark").exists()
    assert not (folder / "pictures").exists()


def test_a_setting_that_does_not_suit_an_image_names_both(ask, folder):
    answer = ask("detect", "deep.png", "a.png", "--set", "full_scale=4095", "--overlay", "pictures")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("simtip: a.png: --set full_scale: the image has 8 bits")
    assert not (folder / "pictures").exists()


def test_pictures_have_names_of_their_own(ask, folder):
    answer = ask("detect", "a.png", "other/a.png", "blank.png", "--overlay", "pictures", *AREA)
    assert (answer.code, answer.err) == (0, "")
    names = {path.name for path in (folder / "pictures").iterdir()}
    layers = ("overlay", "gray", "filtered", "binary", "cleaned", "edges")
    assert names == {f"{stem}_{layer}.png" for stem in ("a", "a_2", "blank") for layer in layers}
    drawn = read_image("pictures/a_overlay.png")
    assert drawn.shape == (120, 160, 3)
    assert not np.array_equal(drawn[..., 0], needle())
    assert np.array_equal(read_image("pictures/a_gray.png"), needle())
    again = ask("detect", "a.png", "--overlay", "pictures")
    assert (again.code, "not empty" in again.err) == (2, True)


def test_layers_of_any_kind_leave_no_file_astray(ask, folder):
    (folder / "layered.py").write_text(
        "import numpy as np\n"
        "def find(image, layers=False):\n"
        "    assert layers\n"
        "    wide = np.linspace(-8e307, 8e307, 4000).reshape(2, 2000)\n"
        "    wide[0, 0] = np.nan\n"
        "    kinds = {'../../up': image, 'overlay': image > 100, 'wide': wide, 'words': 'no',\n"
        "             'line': np.ones(3), 'empty': np.ones((0, 3)), 'complex': 1j * image}\n"
        "    return {'reason': 'none', 'layers': kinds}\n"
    )
    answer = ask("detect", "a.png", "--detector", "layered:find", "--overlay", "pictures")
    sys.modules.pop("layered")
    assert (answer.code, answer.err) == (0, "")
    names = {path.name for path in (folder / "pictures").iterdir()}
    assert names == {"a_overlay.png", "a_overlay_2.png", "a_.._.._up.png", "a_wide.png"}
    assert read_image("pictures/a_wide.png").shape == (1, 800)
    assert set(np.unique(read_image("pictures/a_overlay_2.png"))) == {0, 255}


def test_what_a_detector_prints_leaves_the_json_alone(ask, folder):
    (folder / "talking.py").write_text(
        "print('hello')\ndef find(image):\n    print('here')\n    return (1, 2)\n"
    )
    answer = ask("detect", "a.png", "--detector", "talking:find", "--json")
    sys.modules.pop("talking")
    assert json.loads(answer.out)[0]["tip_px"] == [1, 2]
    assert answer.err == "hello\nhere\n"


@pytest.fixture
def pair(table_1, folder):
    """A pair of the paper's rig, read out around one point, so that the tips match."""
    left, right = (
        Camera(np.array([[2000, 0, 80], [0, 2000, 60], [0, 0, 1.0]]), 160, 120) for _ in range(2)
    )
    rig = StereoRig(left, right, table_1.T_lr)
    write_rig(folder / "rig.yaml", rig)
    return rig


def test_measure_looks_where_it_is_told_and_counts_from_the_whole_image(pair, ask):
    regions = ("--roi-left", "40,30,50,80", "--roi-right", "80,10,60,100")
    call = ("measure", "--rig", "rig.yaml", "a.png", "other/a.png", "--json", *AREA)
    whole, part = items(ask(*call)), items(ask(*call, *regions))
    assert whole["tip_detected_px"] == {"left": [60, 89], "right": [100, 69]}
    assert {**part, "timings_s": 0} == {**whole, "timings_s": 0}
    hidden = items(ask(*call, "--roi-right", "0,0,50,120"))
    assert hidden["status"] == "right_nothing_darker_than_threshold"
    detector = detect.configure("lin2020", {"min_area_px": 100})
    images = read_image("a.png"), read_image("other/a.png")
    seen = measure_pair(*images, pair, detector, regions=(Region(40, 30, 50, 80), None))
    assert seen.left.tip_px.tolist() == [60, 89]


@pytest.mark.usefixtures("pair")
@pytest.mark.parametrize("roi", BAD_REGIONS)
@pytest.mark.parametrize("side", ["left", "right"])
def test_measure_refuses_a_region_that_is_none(side, roi, ask):
    answer = ask("measure", "--rig", "rig.yaml", "a.png", "other/a.png", f"--roi-{side}={roi}")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"simtip: --roi-{side}: ")


def test_a_region_in_python_keeps_axis_covariance_and_confidence():
    def find(image, *, layers=False):
        assert image.shape == (5, 4)
        assert not layers
        return detect.TipObservation.found(
            (1.5, 2), axis_px=(0, 1), covariance_px=np.eye(2), confidence=0.25
        )

    o = within(find, parse_region(" 10, 20,4,5"))(np.zeros((30, 30), np.uint8))
    assert o.tip_px.tolist() == [11.5, 22]
    assert (o.axis_px.tolist(), o.covariance_px.tolist()) == ([0, 1], [[1, 0], [0, 1]])
    assert o.confidence == 0.25
    with pytest.raises(InputError, match="reaches outside"):
        within(find, Region(0, 0, 31, 5))(np.zeros((30, 30), np.uint8))
