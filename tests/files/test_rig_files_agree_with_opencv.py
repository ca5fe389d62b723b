"""Do rig files mean to OpenCV what they mean to us, and is every unusable one refused?"""

import contextlib

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simtip.camera import Camera, StereoRig
from simtip.errors import InputError
from simtip.geometry import Pose
from simtip.rig_file import read_rig, rig_text, write_rig

SETTINGS = settings(derandomize=True, deadline=None, max_examples=40)
SIZE = (2048, 1436)
NODES = ("M1", "D1", "M2", "D2", "R", "T")


def paper_like():
    """OpenCV's six results for a rig like the paper's Table 1."""
    K1 = np.array([[1909.84, 0, 932.97], [0, 1910.22, 657.9], [0, 0, 1]])
    K2 = np.array([[1923.38, 0, 935.88], [0, 1914.32, 729.04], [0, 0, 1]])
    R = cv2.Rodrigues(np.array([0.03, 0.53, -0.05]))[0]
    T = np.array([[-68.9], [-0.7], [23.1]])
    D = np.array([[-0.11, 0.13, 1e-3, -2e-4, 0.02]])
    return {"M1": K1, "D1": D, "M2": K2, "D2": D * 0.7, "R": R, "T": T}


def write_by_opencv(path, nodes, size=SIZE):
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    if size:
        storage.write("image_width", size[0])
        storage.write("image_height", size[1])
    for name, matrix in nodes.items():
        storage.write(name, matrix)
    storage.release()


def read_by_opencv(path):
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    nodes = {name: storage.getNode(name).mat() for name in NODES}
    size = [int(storage.getNode(f"image_{side}").real()) for side in ("width", "height")]
    storage.release()
    return nodes, tuple(size)


def assert_same_rig(found, expected, tolerance=1e-12):
    for a, b in ((found.left, expected.left), (found.right, expected.right)):
        np.testing.assert_array_equal(a.K, b.K)
        assert a.distortion == b.distortion
        assert a.size == b.size
    np.testing.assert_allclose(found.T_lr.R, expected.T_lr.R, rtol=0, atol=tolerance)
    scale = np.linalg.norm(expected.T_lr.t)
    np.testing.assert_allclose(found.T_lr.t, expected.T_lr.t, rtol=0, atol=tolerance * scale)


POINTS = np.array([[-10.0, 20, 170], [15, -12, 190], [0, 0, 150], [30, 25, 210]])


def test_a_file_written_by_opencv_projects_as_opencv_does(tmp_path):
    nodes = paper_like()
    write_by_opencv(tmp_path / "rig.yml", nodes)
    rig = read_rig(tmp_path / "rig.yml")
    left, right = rig.project(POINTS)
    # OpenCV's convention, by OpenCV: extrinsics that map left-camera points to the right camera.
    zero = np.zeros(3)
    by_left = cv2.projectPoints(POINTS, zero, zero, nodes["M1"], nodes["D1"])[0]
    by_right = cv2.projectPoints(
        POINTS, cv2.Rodrigues(nodes["R"])[0], nodes["T"], nodes["M2"], nodes["D2"]
    )[0]
    np.testing.assert_allclose(left, by_left.reshape(-1, 2), atol=1e-9)
    np.testing.assert_allclose(right, by_right.reshape(-1, 2), atol=1e-9)
    # Centre of the right camera in the left frame: -R^T T.
    np.testing.assert_allclose(rig.T_lr.t, -nodes["R"].T @ nodes["T"].ravel(), atol=1e-12)
    assert rig.left.size == rig.right.size == SIZE


def test_opencv_reads_what_is_written(tmp_path):
    write_by_opencv(tmp_path / "a.yml", paper_like())
    rig = read_rig(tmp_path / "a.yml")
    write_rig(tmp_path / "b.yml", rig)
    nodes, size = read_by_opencv(tmp_path / "b.yml")
    assert size == SIZE
    for name, expected in paper_like().items():
        assert nodes[name].shape == expected.shape
        np.testing.assert_allclose(nodes[name], expected, rtol=1e-13, atol=1e-13)
    assert_same_rig(read_rig(tmp_path / "b.yml"), rig)


def test_the_written_file_states_its_convention_and_units():
    T = Pose(np.eye(3), np.array([72.0, 0, 0]))
    camera = Camera(np.array([[100.0, 0, 32], [0, 100, 24], [0, 0, 1]]), 64, 48)
    text = rig_text(StereoRig(camera, camera, T))
    assert text.startswith("%YAML:1.0\n---\n#")
    assert "p_right = R p_left + T" in text
    assert "mm" in text
    # The right camera lies at +72 mm: in OpenCV's convention T is -72.
    assert "data: [ -72.0,\n" in text


def test_a_rig_calibrated_by_opencv_round_trips_and_triangulates(tmp_path):
    true = paper_like() | {"D1": np.zeros((1, 5)), "D2": np.zeros((1, 5))}
    corners = np.zeros((88, 3), np.float32)
    corners[:, :2] = np.mgrid[0:11, 0:8].T.reshape(-1, 2) * 6.0 - [30, 21]
    generator = np.random.default_rng(3)
    boards, left, right = [], [], []
    for _ in range(8):
        turn = cv2.Rodrigues(generator.uniform(-0.5, 0.5, 3))[0]
        points = corners @ turn.T + generator.uniform([-15, -15, 160], [15, 15, 210])
        zero = np.zeros(3)
        boards.append(corners)
        left.append(cv2.projectPoints(points, zero, zero, true["M1"], None)[0])
        rvec = cv2.Rodrigues(true["R"])[0]
        right.append(cv2.projectPoints(points, rvec, true["T"], true["M2"], None)[0])
    left = [p.astype(np.float32) for p in left]
    right = [p.astype(np.float32) for p in right]
    guess = [true[name].copy() for name in ("M1", "D1", "M2", "D2")]
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_K3
    rms, M1, D1, M2, D2, R, T, E, F = cv2.stereoCalibrate(
        boards, left, right, *guess, SIZE, flags=flags
    )[:9]
    assert rms < 1e-3
    nodes = {"M1": M1, "D1": D1, "M2": M2, "D2": D2, "R": R, "T": T, "E": E, "F": F}
    write_by_opencv(tmp_path / "rig.yml", nodes)
    rig = read_rig(tmp_path / "rig.yml")
    write_rig(tmp_path / "again.yml", rig)
    assert_same_rig(read_rig(tmp_path / "again.yml"), rig)
    # Triangulation by OpenCV from our rig: P_right from T_lr's inverse.
    T_rl = rig.T_lr.inverse()
    P1 = rig.left.K @ np.eye(3, 4)
    P2 = rig.right.K @ np.column_stack([T_rl.R, T_rl.t])
    pixels = rig.project(POINTS)
    straight = rig.left.undistort(pixels[0]), rig.right.undistort(pixels[1])
    found = cv2.triangulatePoints(P1, P2, straight[0].T, straight[1].T)
    np.testing.assert_allclose((found[:3] / found[3]).T, POINTS, atol=1e-6)
    # And the true scene through the true cameras comes back to where it is.
    zero = np.zeros(3)
    seen_left = cv2.projectPoints(POINTS, zero, zero, true["M1"], None)[0].reshape(-1, 2)
    seen_right = cv2.projectPoints(
        POINTS, cv2.Rodrigues(true["R"])[0], true["T"], true["M2"], None
    )[0].reshape(-1, 2)
    assert np.abs(rig.project(POINTS)[0] - seen_left).max() < 0.01
    assert np.abs(rig.project(POINTS)[1] - seen_right).max() < 0.01
    # OpenCV's F maps left to right, ours right to left.
    ours = rig.fundamental().T
    assert np.abs(np.abs(ours / np.linalg.norm(ours)) - np.abs(F / np.linalg.norm(F))).max() < 1e-4


@pytest.mark.parametrize(
    "change",
    [
        lambda n: {**n, "D1": n["D1"].T},
        lambda n: {**n, "D1": np.array([n["D1"][0]])},
        lambda n: {**n, "T": n["T"].ravel()},  # OpenCV 5 writes an nd-matrix
        lambda n: {**n, "T": n["T"].T},
        lambda n: {**n, "R": cv2.Rodrigues(n["R"])[0]},
        lambda n: {**n, "Q": np.eye(4), "images": np.zeros((3, 4, 3), np.uint8)},
        lambda n: {
            {"M1": "K1", "M2": "K2", "D1": "distCoeffs1", "D2": "distCoeffs2"}.get(k, k): v
            for k, v in n.items()
        },
        lambda n: {
            {"M1": "cameraMatrix1", "M2": "cameraMatrix2"}.get(k, k): v for k, v in n.items()
        },
    ],
)
def test_other_forms_that_opencv_users_write_mean_the_same(tmp_path, change):
    write_by_opencv(tmp_path / "a.yml", paper_like())
    write_by_opencv(tmp_path / "b.yml", change(paper_like()))
    assert_same_rig(read_rig(tmp_path / "b.yml"), read_rig(tmp_path / "a.yml"))


@pytest.mark.parametrize("shape", [(0, 0), (1, 4), (1, 5), (5, 1), (1, 8), (1, 12), (1, 14)])
def test_every_length_of_distortion_is_kept(tmp_path, shape):
    D = np.arange(1, shape[0] * shape[1] + 1).reshape(shape) * 1e-3
    write_by_opencv(tmp_path / "rig.yml", paper_like() | {"D1": D})
    assert read_rig(tmp_path / "rig.yml").left.distortion == tuple(D.ravel())


def test_single_precision_matrices_are_read(tmp_path):
    nodes = {name: m.astype(np.float32) for name, m in paper_like().items()}
    write_by_opencv(tmp_path / "rig.yml", nodes)
    assert read_rig(tmp_path / "rig.yml").left.K[0, 0] == pytest.approx(1909.84, rel=1e-7)


def test_the_header_of_opencv_3_and_4_is_read(tmp_path):
    write_by_opencv(tmp_path / "a.yml", paper_like())
    text = (tmp_path / "a.yml").read_text().replace("%YAML 1.2", "%YAML:1.0")
    assert "%YAML:1.0" in text
    (tmp_path / "b.yml").write_text(text)
    assert_same_rig(read_rig(tmp_path / "b.yml"), read_rig(tmp_path / "a.yml"))


def test_the_size_comes_from_the_file_and_else_from_the_images(tmp_path):
    path = tmp_path / "rig.yml"
    write_by_opencv(path, paper_like(), size=None)
    with pytest.raises(InputError, match=r"image_width.*missing"):
        read_rig(path)
    assert read_rig(path, (640, 480)).right.size == (640, 480)
    rig = read_rig(path, (640, 480), (320, 240))
    assert (rig.left.size, rig.right.size) == ((640, 480), (320, 240))
    text = path.read_text()
    for nodes, left, right in [
        ("image_size: [ 2048, 1436 ]", SIZE, SIZE),
        ("imageSize: [ 2048., 1436. ]", SIZE, SIZE),
        ("image_size1: [9, 8]\nimage_size2: [7, 6]", (9, 8), (7, 6)),
        ("image_size2: [7, 6]", (640, 480), (7, 6)),
    ]:
        path.write_text(text + nodes + "\n")
        rig = read_rig(path, (640, 480))
        assert (rig.left.size, rig.right.size) == (left, right)


LENGTHS = st.sampled_from([0, 4, 5, 8, 12, 14])
COEFFICIENTS = st.floats(-2, 2)
SIDES = st.integers(1, 65535)
FOCAL = st.floats(1, 1e5)
CENTRE = st.floats(-1e5, 1e5)


@st.composite
def cameras(draw):
    K = np.array([[draw(FOCAL), 0, draw(CENTRE)], [0, draw(FOCAL), draw(CENTRE)], [0, 0, 1]])
    n = draw(LENGTHS)
    D = tuple(draw(st.lists(COEFFICIENTS, min_size=n, max_size=n)))
    return Camera(K, draw(SIDES), draw(SIDES), D)


@SETTINGS
@given(
    left=cameras(),
    right=cameras(),
    turn=st.tuples(*[st.floats(-1.7, 1.7)] * 3),
    t=st.tuples(st.floats(2, 1e4), st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)),
)
def test_any_rig_round_trips(tmp_path_factory, left, right, turn, t):
    rig = StereoRig(left, right, Pose(cv2.Rodrigues(np.array(turn))[0], np.array(t)))
    path = tmp_path_factory.getbasetemp() / "rig.yml"
    write_rig(path, rig)
    assert_same_rig(read_rig(path), rig)
    if left.size == right.size:
        nodes, _ = read_by_opencv(path)
        np.testing.assert_array_equal(nodes["M1"], left.K)


GOOD = rig_text(
    StereoRig(
        Camera(np.array([[100.0, 0, 32], [0, 100, 24], [0, 0, 1]]), 64, 48),
        Camera(np.array([[100.0, 0, 32], [0, 100, 24], [0, 0, 1]]), 64, 48),
        Pose(np.eye(3), np.array([72.0, 0, 0])),
    )
)
LINES = GOOD.split("\n")


def node(name):
    """The text of one matrix node of the good file."""
    start = next(i for i, line in enumerate(LINES) if line.startswith(f"{name}:"))
    end = next(i for i in range(start, len(LINES)) if LINES[i].endswith("]"))
    return "\n".join(LINES[start : end + 1])


def matrix(name, rows, cols, data, dt="d"):
    return f"{name}: !!opencv-matrix\n rows: {rows}\n cols: {cols}\n dt: {dt}\n data: {data}"


def eye(name, **changes):
    entries = [1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0]
    for place, entry in changes.items():
        entries[int(place[1:])] = entry
    return matrix(name, 3, 3, f"[{', '.join(map(str, entries))}]")


UNUSABLE = [
    # node replaced, by, field, fragments
    ("M1", "", "M1", ["missing", "K1", "cameraMatrix1", "extrinsics.yml"]),
    ("D2", "", "D2", ["missing", "distCoeffs2"]),
    ("R", "", "R", ["missing"]),
    ("T", "", "T", ["missing"]),
    ("M1", node("M1") + "\n" + node("M1").replace("M1", "K1"), "K1", ["beside M1", "keep one"]),
    ("M1", node("M1") + "\n" + node("M1"), None, ["duplicate key 'M1'"]),
    ("M1", "M1: 3", "M1", ["no matrix but 3", "cv2.FileStorage"]),
    ("M1", "M1: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "M1", ["no matrix but a list"]),
    ("M1", "M1: {}", "M1", ["has no 'rows'"]),
    ("M1", "M1: {rows: 3, cols: 3, dt: d}", "M1", ["has no 'data'"]),
    ("M1", "M1: {sizes: [3, 3], data: []}", "M1", ["has no 'dt'"]),
    ("M1", "M1: {sizes: [1, 3, 3], dt: d, data: []}", "M1.sizes", ["shape"]),
    ("M1", matrix("M1", 3, 3, "[1, 2]"), "M1.data", ["2 entries for 3 x 3"]),
    ("M1", matrix("M1", 65535, 65535, "[1, 2]"), "M1.data", ["2 entries for 65535 x 65535"]),
    ("M1", matrix("M1", 10**12, 3, "[1]"), "M1.rows", ["shape"]),
    ("M1", matrix("M1", -3, -3, "[1]"), "M1.rows", ["shape"]),
    ("M1", matrix("M1", "three", 3, "[1]"), "M1.rows", ["shape"]),
    ("M1", matrix("M1", "true", 3, "[1]"), "M1.rows", ["shape"]),
    ("M1", matrix("M1", 3, 3, "[1]", dt='"3d"'), "M1.dt", ["'3d'", "one channel"]),
    ("M1", matrix("M1", 3, 3, "[1]", dt="q"), "M1.dt", ["'q'"]),
    ("M1", matrix("M1", 3, 3, "[1]", dt="3"), "M1.dt", ["not the type"]),
    ("M1", matrix("M1", 3, 3, "5"), "M1.data", ["list of numbers"]),
    ("M1", matrix("M1", 2, 2, "[1, 0, 0, 1]"), "M1", ["is 2 x 2", "has to be 3 x 3"]),
    ("M1", matrix("M1", 1, 9, "[1, 0, 0, 0, 1, 0, 0, 0, 1]"), "M1", ["is 1 x 9"]),
    ("M2", eye("M2", _0=".Nan"), "M2.data[0]", ["nan"]),
    ("M2", eye("M2", _2=".Inf"), "M2.data[2]", ["inf"]),
    ("M2", eye("M2", _0="1e300"), "M2.data[0]", ["1e+300"]),
    ("M2", eye("M2", _0="9" * 200), "M2.data[0]", ["999..."]),
    ("M2", eye("M2", _0="abc"), "M2.data[0]", ["'abc'", "not a number"]),
    ("M2", eye("M2", _0="true"), "M2.data[0]", ["true, not a number"]),
    ("M2", eye("M2", _0="[1]"), "M2.data[0]", ["a list of 1, not a number"]),
    ("M2", eye("M2", _0=0), "M2", ["singular", "focal lengths are 0"]),
    ("M2", eye("M2", _4=0), "M2", ["singular"]),
    ("M2", eye("M2", _4=-100), "M2", ["-100"]),
    ("M2", eye("M2", _1=0.01), "M2", ["skew 0.01", "not supported"]),
    ("M2", eye("M2", _3=0.01), "M2", ["not an intrinsic matrix"]),
    ("M2", eye("M2", _8=2), "M2", ["not an intrinsic matrix"]),
    ("M2", eye("M2", _6=1), "M2", ["not an intrinsic matrix"]),
    ("D1", matrix("D1", 1, 3, "[1, 2, 3]"), "D1", ["1 x 3 coefficients", "4, 5, 8, 12, 14"]),
    ("D1", matrix("D1", 2, 2, "[1, 2, 3, 4]"), "D1", ["2 x 2 coefficients"]),
    ("D1", matrix("D1", 1, 4, "[1, 2, 3, .nan]"), "D1.data[3]", ["nan"]),
    ("R", eye("R", _0=2), "R", ["not a rotation", "stereoCalibrate"]),
    ("R", eye("R", _0=-1), "R", ["mirrors"]),
    ("R", eye("R", _0=0), "R", ["not a rotation"]),
    ("R", eye("R", _0=".nan"), "R.data[0]", ["nan"]),
    ("R", eye("R", _0="1e8", _1="1e8"), "R", ["not a rotation"]),
    ("R", matrix("R", 2, 2, "[1, 0, 0, 1]"), "R", ["is 2 x 2"]),
    ("T", matrix("T", 3, 1, "[0, 0, 0]"), "T", ["baseline of 0 mm", "metres"]),
    ("T", matrix("T", 3, 1, "[1e-300, 0, 0]"), "T", ["baseline of 0 mm"]),
    ("T", matrix("T", 2, 1, "[1, 0]"), "T", ["is 2 x 1", "3 x 1"]),
    ("T", matrix("T", 3, 1, "[1, .inf, 0]"), "T.data[1]", ["inf"]),
    ("T", "T: !!python/tuple [1, 2, 3]", "T", ["!!python/tuple"]),
]


@pytest.mark.parametrize(("name", "by", "field", "fragments"), UNUSABLE)
def test_an_unusable_node_is_named(tmp_path, name, by, field, fragments):
    path = tmp_path / "rig.yml"
    path.write_text(GOOD.replace(node(name), by))
    with pytest.raises(InputError) as caught:
        read_rig(path, SIZE)
    message = str(caught.value)
    assert caught.value.field == field
    assert message.startswith(str(path))
    assert caught.value.remedy
    assert "\n" not in message
    for fragment in fragments:
        assert fragment in message
    if by:
        assert caught.value.line


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("image_width: 0\nimage_height: 48", "image_width"),
        ("image_width: 64", "image_height"),
        ("image_width: 64\nimage_height: 48.5", "image_height"),
        ("image_width: 64\nimage_height: .nan", "image_height"),
        ("image_width: wide\nimage_height: 48", "image_width"),
        ("image_width: true\nimage_height: 48", "image_width"),
        ("image_width: 99999999\nimage_height: 48", "image_width"),
        ("image_size: 64", "image_size"),
        ("image_size: [64]", "image_size"),
        ("image_size: [64, -48]", "image_size[1]"),
    ],
)
def test_an_impossible_size_is_named(tmp_path, text, field):
    path = tmp_path / "rig.yml"
    path.write_text(GOOD.replace("image_width: 64\nimage_height: 48", text))
    with pytest.raises(InputError) as caught:
        read_rig(path, SIZE)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("content", "fragment"),
    [
        (b"", "is empty"),
        (b"%YAML:1.0\n---\n", "is empty"),
        (b"<?xml version='1.0'?>\n<opencv_storage>", "not valid XML"),
        (b'{"M1": {}}', "M1: the matrix has no 'rows'"),
        (b"\xef\xbb\xbf \n{}", "M1: the node is missing"),
        (b"[1, 2]", "named nodes"),
        (b"%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: [", "not valid YAML"),
        (b"\x89PNG\r\n\x1a\n\0\0", "not UTF-8"),
        (b"a: 1\n" * 300_000, "more than the limit"),
    ],
)
def test_a_file_that_is_no_rig_is_refused(tmp_path, content, fragment):
    path = tmp_path / "rig.yml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=fragment) as caught:
        read_rig(path, SIZE)
    assert str(caught.value).startswith(str(path))


def test_missing_files_and_folders_are_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none.yml"):
        with pytest.raises(InputError):
            read_rig(path)
    rig = StereoRig(
        *[Camera(np.diag([9.0, 9, 1]), 9, 9)] * 2, Pose(np.eye(3), np.array([1.0, 0, 0]))
    )
    for path in (tmp_path, tmp_path / "no" / "folder.yml", "/dev/null"):
        with pytest.raises(InputError):
            write_rig(path, rig)
    assert list(tmp_path.iterdir()) == []


@SETTINGS
@given(st.data())
def test_no_other_error_escapes_from_a_garbled_file(tmp_path_factory, data):
    text = list(GOOD)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at] = data.draw(st.sampled_from(["", "9", "-", "e", ".", "\n", " ", "[", "x", "0"]))
    path = tmp_path_factory.getbasetemp() / "garbled.yml"
    path.write_text("".join(text))
    with contextlib.suppress(InputError):
        assert isinstance(read_rig(path, SIZE), StereoRig)
