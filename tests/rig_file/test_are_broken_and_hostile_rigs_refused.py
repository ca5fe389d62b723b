"""Is every rig file that cannot be used refused in one line that names file, field and remedy?"""

import contextlib
import json

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from rig_examples import SETTINGS, assert_same_rig, paper_like

from simtip.camera import StereoRig
from simtip.errors import InputError
from simtip.rig_file import read_rig, rig_text, write_rig

RIG = paper_like(4)
XML = rig_text(RIG, "opencv-xml")
JSON = rig_text(RIG, "json")
KALIBR = rig_text(RIG, "kalibr")
KALIBR_DATA = yaml.safe_load(KALIBR)


def refused(path, size=None):
    """The one line, after checking its form."""
    with pytest.raises(InputError) as caught:
        read_rig(path, size)
    error = caught.value
    assert str(error).startswith(str(error.file))
    assert "\n" not in str(error)
    assert error.remedy
    return error


LAUGHS = "<!DOCTYPE a [<!ENTITY a0 'ha'>" + "".join(
    f"<!ENTITY a{i} '{f'&a{i - 1};' * 10}'>" for i in range(1, 10)
)


@pytest.mark.parametrize(
    ("content", "fragment"),
    [
        (f"{LAUGHS}]><opencv_storage>&a9;</opencv_storage>", "document type"),
        ("<!DOCTYPE a [<!ENTITY x SYSTEM 'file:///dev/zero'>]><a>&x;</a>", "document type"),
        ("<!DOCTYPE a SYSTEM 'http://localhost/a.dtd'><opencv_storage/>", "document type"),
        ("<opencv_storage>&undeclared;</opencv_storage>", "undefined entity"),
        ("<opencv_storage>" + "<a>" * 100_000, "nested deeper than 64"),
        ("<opencv_storage>" + "<a/>" * 100_000 + "</opencv_storage>", "more than 50000 values"),
        ("<opencv_storage><a>" + "1 " * 60_000 + "</a></opencv_storage>", "more than 50000"),
        ("<opencv_storage>\n<M1>\n", "not valid XML: no element found"),
        ("<opencv_storage></M1>", "mismatched tag"),
        ("<html><body/></html>", "XML of <html>, not of <opencv_storage>"),
        ("<opencv_storage/>", "M1: the node is missing"),
        ("<opencv_storage>1 2 3</opencv_storage>", "named nodes, not a list of 3"),
        ("<?xml version='1.0' encoding='nonsense'?><opencv_storage/>", "not valid XML"),
        ("<?xml version='1.0' encoding='utf-16'?><opencv_storage/>", "not valid XML"),
        ("<opencv_storage><a>\x00</a></opencv_storage>", "not valid XML"),
    ],
)
def test_hostile_xml_is_refused(tmp_path, content, fragment):
    path = tmp_path / "rig.xml"
    path.write_text(content)
    assert fragment in str(refused(path, (64, 48)))


@pytest.mark.parametrize(
    ("old", "new", "field", "fragment"),
    [
        ("<M1 ", "<N1 ", None, "mismatched tag"),
        ("1909.84 ", "text ", "M1.data[0]", "the text 'text', not a number"),
        ("1909.84 ", '"1909.84" ', "M1.data[0]", "the text '1909.84', not a number"),
        ("1909.84 ", ".Nan ", "M1.data[0]", "nan, which no rig has"),
        ("1909.84 ", ".Inf ", "M1.data[0]", "inf"),
        ("1909.84 ", "1e300 ", "M1.data[0]", "1e+300"),
        ("1909.84 ", "1e999 ", None, "the number 1e999 is too large"),
        ("1909.84 ", "9" * 100_000 + " ", None, "too long"),
        ("1909.84 ", "", "M1.data", "8 entries for 3 x 3"),
        ("<rows>3</rows>", "", "M1", "has no 'rows'"),
        ("<rows>3</rows>", "<rows>-3</rows>", "M1.rows", "not the shape"),
        ("<rows>3</rows>", "<rows>3</rows><rows>3</rows>", None, "has <rows> twice"),
        ("<dt>d</dt>", "<dt>3f</dt>", "M1.dt", "'3f'"),
        ("<image_width>2048<", "<image_width>0<", "image_width", "from 1 to 65535"),
        ("<image_width>2048<", "<image_width><_/><", "image_width", "a list of 1"),
    ],
)
def test_a_broken_xml_node_is_named(tmp_path, old, new, field, fragment):
    path = tmp_path / "rig.xml"
    assert old in XML
    path.write_text(XML.replace(old, new, 1))
    error = refused(path)
    assert error.field == field
    assert fragment in str(error)
    assert error.line


def test_an_element_in_place_of_a_number_is_named(tmp_path):
    path = tmp_path / "rig.xml"
    path.write_text(XML.replace("2048</image_width>", "<a>2</a></image_width>"))
    assert "image_width: is a mapping" in str(refused(path))


def test_cdata_comments_and_a_byte_order_mark_are_plain_xml(tmp_path):
    path = tmp_path / "rig.xml"
    text = XML.replace("1909.84", "<!-- fx --><![CDATA[1909.84]]>").replace("?>\n", "?>\n\n<?a b?>")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert_same_rig(read_rig(path), RIG)


def changed(**changes):
    """The good JSON with other values; None removes."""
    contents = {**json.loads(JSON), **changes}
    return json.dumps({key: value for key, value in contents.items() if value is not None})


EYE = [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]


@pytest.mark.parametrize(
    ("content", "field", "fragment"),
    [
        ("{" * 100, None, "not valid JSON"),
        ('{"a":' * 5000 + "1" + "}" * 5000, None, "nested deeper than 64"),
        ('{"a":' * 70 + "1" + "}" * 70, None, "nested deeper than 64"),
        ('{"a":' + "[" * 100_000 + "]" * 100_000 + "}", None, "nested deeper than 64"),
        (json.dumps({"a": [0] * 60_000}), None, "more than 50000 values"),
        ('{"format": "simtip-rig"\n"version": 1}', None, "not valid JSON"),
        ('{"format": 1, "format": 2}', None, "the key 'format' twice"),
        (JSON.replace("1909.84", "NaN"), None, "has NaN"),
        (JSON.replace("1909.84", "-Infinity"), None, "has -Infinity"),
        (JSON.replace("1909.84", "1e999"), None, "has the number 1e999"),
        (JSON.replace("1909.84", "9" * 10_000), None, "10000 digits"),
        (JSON.replace("1909.84", "1e300"), "K_left[0][0]", "1e+300, which no rig has"),
        (JSON.replace("1909.84", '"1909.84"'), "K_left[0][0]", "not a number"),
        (JSON.replace("1909.84", "true"), "K_left[0][0]", "true, not a number"),
        (JSON.replace("1909.84", "-1909.84"), "K_left", "singular"),
        (changed(format=None), "format", "missing"),
        (changed(format="other"), "format", 'a rig has "simtip-rig"'),
        (changed(version=None), "version", "missing"),
        (changed(version=2), "version", "reads version 1; update simtip"),
        (changed(version=True), "version", "true"),
        (changed(K_left=None), "K_left", "missing"),
        (changed(K_left=EYE[:2]), "K_left", "no 3 x 3 matrix"),
        (changed(K_left=[[1, 2], [3], 4]), "K_left[2]", "list of numbers"),
        (changed(K_left=[*EYE[:2], [0, 0]]), "K_left", "no 3 x 3 matrix"),
        (changed(K_right=[[1, 0.1, 0], *EYE[1:]]), "K_right", "skew"),
        (changed(D_left=None), "D_left", "missing"),
        (changed(D_left=[1, 2, 3]), "D_left", "3 coefficients"),
        (changed(D_left={}), "D_left", "a mapping"),
        (changed(size_left=None), "size_left", "missing"),
        (changed(size_left=[2048]), "size_left", "[width, height]"),
        (changed(size_right=[2048, 0.5]), "size_right[1]", "whole number"),
        (changed(R=[[2, 0, 0], *EYE[1:]]), "R", "not a rotation"),
        (changed(R=[[-1, 0, 0], *EYE[1:]]), "R", "mirrors"),
        (changed(T_mm=[1, 2]), "T_mm", "2 numbers"),
        (changed(T_mm=[-0.072, 0, 0]), "T_mm", "multiply metres by 1000"),
    ],
)
def test_broken_json_is_named(tmp_path, content, field, fragment):
    path = tmp_path / "rig.json"
    path.write_text(content)
    error = refused(path)
    assert error.field == field
    assert fragment in str(error)


def test_json_of_another_encoding_is_refused(tmp_path):
    path = tmp_path / "rig.json"
    path.write_bytes(JSON.encode()[:-3] + b"\n\xff}")
    error = refused(path)
    assert "not UTF-8" in str(error)
    assert error.line == JSON.count("\n")


def chain(**cameras):
    """The good camchain with other fields in a camera; None removes."""
    contents = yaml.safe_load(KALIBR)
    for name, changes in cameras.items():
        merged = {**contents.get(name, {}), **changes}
        contents[name] = {key: value for key, value in merged.items() if value is not None}
    return yaml.safe_dump(contents)


POSE = KALIBR_DATA["cam1"]["T_cn_cnm1"]


@pytest.mark.parametrize(
    ("content", "field", "fragment"),
    [
        (chain(cam2={}), None, "cam0, cam1, cam2; a rig has cam0, left"),
        (yaml.safe_dump({"cam0": {}}), None, "the cameras cam0;"),
        (chain(cam1={"T_cn_cnm1": None}), "cam1.T_cn_cnm1", "missing"),
        (chain(cam1={"T_cn_cnm1": POSE[:3]}), "cam1.T_cn_cnm1", "no 4 x 4"),
        (chain(cam1={"T_cn_cnm1": [*POSE[:3], [0, 0, 1, 1]]}), "cam1.T_cn_cnm1", "rigid"),
        (chain(cam1={"T_cn_cnm1": [[2, 0, 0, 1], *POSE[1:]]}), "cam1.T_cn_cnm1", "not a rotation"),
        (
            chain(cam1={"T_cn_cnm1": [[*row[:3], 1000 * row[3]] for row in POSE[:3]] + POSE[3:]}),
            "cam1.T_cn_cnm1",
            "baseline of 72.7 m; this format is in metres",
        ),
        (chain(cam0={"camera_model": "omni"}), "cam0.camera_model", "'omni', which OpenCV's"),
        (
            chain(cam1={"distortion_model": "equidistant"}),
            "cam1.distortion_model",
            "'equidistant', which OpenCV's standard model cannot hold; calibrate with",
        ),
        (chain(cam1={"distortion_model": "fov"}), "cam1.distortion_model", "'fov'"),
        (chain(cam1={"distortion_model": 5}), "cam1.distortion_model", "not text"),
        (chain(cam1={"distortion_model": "none"}), "cam1.distortion_coeffs", "4 coefficients"),
        (chain(cam1={"distortion_coeffs": [1, 2]}), "cam1.distortion_coeffs", "2 coefficients"),
        (chain(cam1={"intrinsics": [1, 2, 3]}), "cam1.intrinsics", "3 numbers"),
        (chain(cam1={"intrinsics": [1, 2, 3, "x"]}), "cam1.intrinsics[3]", "not a number"),
        (chain(cam1={"intrinsics": [0, 2, 3, 4]}), "cam1.intrinsics", "singular"),
        (chain(cam1={"resolution": None}), "cam1.resolution", "missing"),
        (chain(cam1={"resolution": [0, 5]}), "cam1.resolution[0]", "whole number"),
        ("cam0: 5\ncam1: 6\n", "cam1", "is 6, not named values"),
    ],
)
def test_a_broken_camchain_is_named(tmp_path, content, field, fragment):
    path = tmp_path / "camchain.yaml"
    path.write_text(content)
    error = refused(path)
    assert error.field == field
    assert fragment in str(error)
    assert error.line


@pytest.fixture
def pair(tmp_path):
    write_rig(tmp_path / "pair", RIG, "ros")
    return tmp_path / "pair"


def change(file, **changes):
    contents = {**yaml.safe_load(file.read_text()), **changes}
    file.write_text(yaml.safe_dump({k: v for k, v in contents.items() if v is not None}))


def matrix(rows, cols, data):
    return {"rows": rows, "cols": cols, "data": data}


@pytest.mark.parametrize(
    ("side", "changes", "field", "fragment"),
    [
        ("left", {"camera_matrix": None}, "camera_matrix", "missing"),
        ("right", {"rectification_matrix": None}, "rectification_matrix", "missing"),
        ("left", {"image_width": None}, "image_width", "missing"),
        ("left", {"image_height": 0}, "image_height", "whole number"),
        ("left", {"camera_matrix": matrix(3, 3, [0.0] * 9)}, "camera_matrix", "singular"),
        ("left", {"camera_matrix": matrix(3, 3, [0.0])}, "camera_matrix.data", "1 entries"),
        ("left", {"camera_matrix": [1, 2]}, "camera_matrix", "no matrix but a list of 2"),
        ("left", {"camera_matrix": {"rows": 3}}, "camera_matrix", "has no 'cols'"),
        ("right", {"distortion_model": "equidistant"}, "distortion_model", "cannot hold"),
        ("right", {"distortion_model": []}, "distortion_model", "not text"),
        (
            "right",
            {"distortion_model": "rational_polynomial"},
            "distortion_coefficients",
            "1 x 5 coefficients; give one row of 8",
        ),
        (
            "right",
            {"distortion_coefficients": matrix(1, 8, [0.1] * 8)},
            "distortion_coefficients",
            "1 x 8 coefficients; give one row of 0, 4, 5",
        ),
        (
            "right",
            {"rectification_matrix": matrix(3, 3, [0.0] * 9)},
            "rectification_matrix",
            "not a rotation",
        ),
        (
            "right",
            {"projection_matrix": matrix(3, 4, [9.0, 0, 5, 0, 0, 9, 5, 0, 0, 0, 1, 0])},
            "projection_matrix",
            "has no baseline: its fourth column is 0; calibrate the two cameras together",
        ),
        (
            "right",
            {"projection_matrix": matrix(3, 4, [9.0, 0, 5, -900, 0, 9, 5, 0, 0, 0, 1, 0])},
            "projection_matrix",
            "baseline of 100 m; this format is in metres",
        ),
        (
            "right",
            {"projection_matrix": matrix(3, 4, [9.0, 0, 5, -1, 0, 9, 5, 0, 0, 0, 1, 1])},
            "projection_matrix",
            "not side by side",
        ),
        (
            "left",
            {"projection_matrix": matrix(3, 4, [9.0, 0, 5, -1, 0, 9, 5, 0, 0, 0, 1, 0])},
            "projection_matrix",
            "not a left camera's",
        ),
        (
            "left",
            {"projection_matrix": matrix(3, 3, [9.0, 0, 5, 0, 9, 5, 0, 0, 1])},
            "projection_matrix",
            "is 3 x 3; it has to be 3 x 4",
        ),
    ],
)
def test_a_broken_ros_file_is_named(pair, side, changes, field, fragment):
    change(pair / f"{side}.yaml", **changes)
    error = refused(pair)
    assert error.file == str(pair / f"{side}.yaml")
    assert error.field == field
    assert fragment in str(error)
    assert error.line


def test_a_ros_file_of_no_named_model_is_plumb_bob(pair):
    change(pair / "left.yaml", distortion_model=None)
    assert_same_rig(read_rig(pair), RIG)


def test_swapped_ros_files_are_told_from_right_ones(pair):
    (pair / "left.yaml").rename(pair / "other.yaml")
    (pair / "right.yaml").rename(pair / "left.yaml")
    (pair / "other.yaml").rename(pair / "right.yaml")
    assert "the two files are swapped" in str(refused(pair))


@pytest.mark.parametrize(
    ("name", "left", "right"),
    [
        ("left.yaml", "left.yaml", "right.yaml"),
        ("right.yaml", "left.yaml", "right.yaml"),
        ("", "left.yml", "right.yml"),
        ("", "narrow_left.yaml", "narrow_right.yaml"),
        ("Right_camera.yaml", "Left_camera.yaml", "Right_camera.yaml"),
        ("camLEFT.yaml", "camLEFT.yaml", "camRIGHT.yaml"),
    ],
)
def test_either_file_or_the_folder_names_a_pair(pair, name, left, right):
    (pair / "left.yaml").rename(pair / left)
    (pair / "right.yaml").rename(pair / right)
    (pair / "rig_true.yaml").write_text(rig_text(RIG))
    assert_same_rig(read_rig(pair / name), RIG)


def test_a_pair_can_be_written_under_other_names(tmp_path):
    write_rig(tmp_path / "cam_right.yml", RIG, "ros")
    assert {p.name for p in tmp_path.iterdir()} == {"cam_left.yml", "cam_right.yml"}
    assert_same_rig(read_rig(tmp_path), RIG)


def test_half_a_pair_or_too_many_is_refused(pair):
    text = (pair / "left.yaml").read_text()
    (pair / "right.yaml").unlink()
    for path in (pair, pair / "left.yaml"):
        assert "right.yaml: left.yaml is there without it" in str(refused(path))
    (pair / "left.yaml").rename(pair / "camera.yaml")
    assert "its name does not say which" in str(refused(pair / "camera.yaml"))
    assert "no pair" in str(refused(pair))
    for name in ("a_left.yaml", "b_left.yaml", "left_right.yaml"):
        (pair / name).write_text(text)
    assert "more than one pair" in str(refused(pair))
    assert "its name does not say which" in str(refused(pair / "left_right.yaml"))


def test_left_and_right_alone_go_before_other_pairs(pair):
    (pair / "old_left.yaml").write_text("broken")
    assert_same_rig(read_rig(pair), RIG)


def test_paths_that_cannot_be_looked_at_are_refused(tmp_path):
    for name in ("x" * 5000, "a\0b", "no/left.yaml", "x" * 5000 + "/left.yaml"):
        assert refused(tmp_path / name)
        with pytest.raises(InputError):
            write_rig(tmp_path / name, RIG, "ros")
    assert list(tmp_path.iterdir()) == []


def test_a_link_that_leads_to_itself_is_refused(pair):
    (pair / "right.yaml").unlink()
    (pair / "right.yaml").symlink_to(pair / "right.yaml")
    assert "cannot be read" in str(refused(pair / "left.yaml"))


def test_opencvs_sample_of_one_camera_is_not_taken_for_ros(tmp_path):
    (tmp_path / "left.yaml").write_text("%YAML:1.0\n---\ncamera_matrix: 5\n")
    assert "M1: the node is missing" in str(refused(tmp_path / "left.yaml", (64, 48)))


GARBLE = ["", "9", "-", "e", ".", "\n", " ", "[", "x", "0", "<", ">", '"', "{", "}", "&", ":", "]"]


@pytest.mark.parametrize("text", [XML, JSON, KALIBR], ids=["xml", "json", "kalibr"])
def test_no_other_error_escapes_from_a_garbled_file(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("garbled") / "rig"

    @SETTINGS
    @given(
        st.lists(
            st.tuples(st.integers(0, len(text) - 1), st.sampled_from(GARBLE)),
            min_size=1,
            max_size=4,
        )
    )
    def read(changes):
        letters = list(text)
        for place, letter in changes:
            letters[place] = letter
        path.write_text("".join(letters))
        with contextlib.suppress(InputError):
            assert isinstance(read_rig(path), StereoRig)

    read()


@SETTINGS
@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=4)
            | st.dictionaries(st.sampled_from(["rows", "data", "cam0", "intrinsics"]), inner)
        ),
        max_leaves=8,
    ),
    st.sampled_from(sorted(json.loads(JSON))),
)
def test_no_other_error_escapes_from_data_of_another_kind(tmp_path_factory, value, key):
    path = tmp_path_factory.getbasetemp() / "kind.json"
    path.write_text(json.dumps({**json.loads(JSON), key: value}))
    with contextlib.suppress(InputError):
        assert isinstance(read_rig(path), StereoRig)
    for name in ("cam0", "cam1"):
        path.write_text(yaml.safe_dump({**KALIBR_DATA, name: value}))
        with contextlib.suppress(InputError):
            assert isinstance(read_rig(path), StereoRig)
