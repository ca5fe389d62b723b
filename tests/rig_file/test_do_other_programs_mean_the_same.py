"""Do the files mean to OpenCV, ROS and Kalibr what they mean to us, both ways?

Oracles: OpenCV's own reader and writer, `cv2.stereoRectify` and `cv2.undistortPoints`, the formulas
of sensor_msgs/CameraInfo, and YAML 1.1 as PyYAML, which Kalibr uses, reads it.
"""

import json

import cv2
import numpy as np
import pytest
import yaml
from rig_examples import (
    K_LEFT,
    K_RIGHT,
    POINTS,
    SIZE,
    T_MM,
    D,
    R,
    assert_same_rig,
    paper_like,
)

from simtip.rig_file import read_rig, write_rig
from simtip.rig_file.rectification import rectify

LEFT_D, RIGHT_D = np.array(D[:5]), 0.7 * np.array(D[:5])
ZERO = np.zeros(3)


def seen_by_opencv():
    """Where the points are seen, by OpenCV's convention: (n, 2) px in each image."""
    left = cv2.projectPoints(POINTS, ZERO, ZERO, K_LEFT, LEFT_D)[0]
    right = cv2.projectPoints(POINTS, cv2.Rodrigues(R)[0], T_MM, K_RIGHT, RIGHT_D)[0]
    return left.reshape(-1, 2), right.reshape(-1, 2)


def assert_sees_as_opencv(rig, tolerance_px=1e-6):
    for found, expected in zip(rig.project(POINTS), seen_by_opencv(), strict=True):
        np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance_px)


NODES = {"M1": K_LEFT, "D1": LEFT_D[None], "M2": K_RIGHT, "D2": RIGHT_D[None]}
NODES |= {"R": R, "T": T_MM.reshape(3, 1)}


@pytest.mark.parametrize("ending", ["xml", "json", "yml"])
@pytest.mark.parametrize("flat", [False, True])
def test_what_opencv_writes_is_read(tmp_path, ending, flat):
    storage = cv2.FileStorage(str(tmp_path / f"rig.{ending}"), cv2.FILE_STORAGE_WRITE)
    storage.write("comment", 'calibrated "today" <a & b>')
    storage.write("nothing", np.zeros((0, 0)))
    storage.startWriteStruct("image_size", cv2.FileNode_SEQ | cv2.FileNode_FLOW)
    for side in SIZE:
        storage.write("", side)
    storage.endWriteStruct()
    storage.startWriteStruct("views", cv2.FileNode_SEQ)
    for name in ("a view.png", "b.png"):
        storage.write("", name)
    storage.endWriteStruct()
    for name, matrix in NODES.items():
        # One dimension is an nd-matrix to OpenCV 5.
        storage.write(name, matrix.ravel() if flat and name in {"T", "D1"} else matrix)
    storage.release()
    rig = read_rig(tmp_path / f"rig.{ending}")
    assert_same_rig(rig, paper_like(5))
    assert_sees_as_opencv(rig, 1e-9)


@pytest.mark.parametrize("ending", ["xml", "yml"])
@pytest.mark.parametrize("right_size", [SIZE, (640, 480)])
def test_opencv_reads_what_is_written(tmp_path, ending, right_size):
    path = tmp_path / f"rig.{ending}"
    write_rig(path, paper_like(5, right_size=right_size))
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    for name, expected in NODES.items():
        found = storage.getNode(name).mat()
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-13)
    if right_size == SIZE:
        sizes = [[storage.getNode(f"image_{n}").real() for n in ("width", "height")]]
    else:
        nodes = [storage.getNode(f"image_size{n}") for n in "12"]
        sizes = [[node.at(i).real() for i in range(2)] for node in nodes]
    assert sizes == ([list(SIZE)] if right_size == SIZE else [list(SIZE), list(right_size)])
    storage.release()


def write_ros_by_opencv(folder, digits=17, names=("left.yaml", "right.yaml"), **rectify):
    """The pair that ROS's calibrator writes: stereoRectify's R_i and P_i, T in metres."""
    R1, R2, P1, P2 = cv2.stereoRectify(
        K_LEFT, LEFT_D, K_RIGHT, RIGHT_D, SIZE, R, T_MM[:, None] / 1000, **rectify
    )[:4]
    halves = (K_LEFT, LEFT_D, R1, P1), (K_RIGHT, RIGHT_D, R2, P2)
    for name, (K, coefficients, turn, P) in zip(names, halves, strict=True):
        matrices = {
            "camera_matrix": K,
            "distortion_coefficients": coefficients[None],
            "rectification_matrix": turn,
            "projection_matrix": P,
        }
        contents = {"image_width": SIZE[0], "image_height": SIZE[1], "camera_name": "narrow"}
        contents["distortion_model"] = "plumb_bob"
        for key, matrix in matrices.items():
            data = [float(f"{x:.{digits}g}") for x in matrix.ravel().tolist()]
            contents[key] = {"rows": matrix.shape[0], "cols": matrix.shape[1], "data": data}
        (folder / name).write_text(yaml.safe_dump(contents))


@pytest.mark.parametrize("alpha", [-1, 0.0, 1.0])
@pytest.mark.parametrize("flags", [0, cv2.CALIB_ZERO_DISPARITY])
def test_the_pose_of_a_ros_pair_is_found_whatever_the_rectified_view(tmp_path, alpha, flags):
    write_ros_by_opencv(tmp_path, alpha=alpha, flags=flags)
    rig = read_rig(tmp_path)
    assert_same_rig(rig, paper_like(5))
    assert_sees_as_opencv(rig)


def test_each_axis_of_a_ros_projection_has_its_own_focal_length(tmp_path):
    for rows, T_mm in (
        ([[2, 0, 1, -0.2], [0, 4, 1, 0]], [-100, 0, 0]),
        (
            [[2, 0, 1, 0], [0, 4, 1, -0.2]],
            [0, -50, 0],
        ),
    ):
        for side, K in (("left", K_LEFT), ("right", K_RIGHT)):
            P = np.array([*rows, [0, 0, 1, 0]], float)
            P[:, 3] *= side == "right"
            matrices = {"camera_matrix": K, "distortion_coefficients": np.zeros((1, 5))}
            matrices |= {"rectification_matrix": np.eye(3), "projection_matrix": P}
            half = {
                key: {"rows": m.shape[0], "cols": m.shape[1], "data": m.ravel().tolist()}
                for key, m in matrices.items()
            }
            half |= {"image_width": 64, "image_height": 48}
            (tmp_path / f"{side}.yaml").write_text(yaml.safe_dump(half))
        np.testing.assert_allclose(read_rig(tmp_path).T_lr.inverse().t, T_mm, atol=1e-12)


def test_a_ros_pair_of_few_digits_is_as_good_as_they_are(tmp_path):
    write_ros_by_opencv(tmp_path, digits=7)
    rig = read_rig(tmp_path / "left.yaml")
    np.testing.assert_allclose(rig.T_lr.R, R.T, rtol=0, atol=1e-6)
    np.testing.assert_allclose(rig.T_lr.t, -R.T @ T_MM, rtol=0, atol=1e-4)


def read_ros_by_the_book(folder):
    """Each half's matrices, as YAML 1.1 reads them."""
    for side in ("left", "right"):
        half = yaml.safe_load((folder / f"{side}.yaml").read_text())
        matrices = {}
        for key, node in half.items():
            if isinstance(node, dict):
                assert all(isinstance(x, float) for x in node["data"])
                matrices[key] = np.array(node["data"]).reshape(node["rows"], node["cols"])
        assert (half["image_width"], half["image_height"]) == SIZE
        yield half["distortion_model"], matrices


@pytest.mark.parametrize(("count", "model"), [(5, "plumb_bob"), (8, "rational_polynomial")])
def test_ros_finds_the_depth_of_points_in_what_is_written(tmp_path, count, model):
    rig = paper_like(count)
    write_rig(tmp_path / "pair", rig, "ros")
    rectified, projections = [], []
    for (name, half), pixels in zip(
        read_ros_by_the_book(tmp_path / "pair"), rig.project(POINTS), strict=True
    ):
        assert name == model
        P = half["projection_matrix"]
        projections.append(P)
        straight = cv2.undistortPoints(
            pixels.reshape(-1, 1, 2),
            half["camera_matrix"],
            half["distortion_coefficients"],
            R=half["rectification_matrix"],
            P=P[:, :3],
            criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-14),
        )
        rectified.append(straight.reshape(-1, 2))
        turn = half["rectification_matrix"]
        if len(projections) == 1:
            in_view = POINTS @ turn.T / 1000
    left, right = rectified
    P_left, P_right = projections
    np.testing.assert_array_equal(P_left[:, :3], P_right[:, :3])  # as image_geometry demands
    np.testing.assert_array_equal(P_left[:, 3], 0)
    # Rows agree; baseline -P[0, 3] / f in metres; depth f B / disparity (CameraInfo).
    np.testing.assert_allclose(left[:, 1], right[:, 1], atol=1e-6)
    f, baseline = P_right[0, 0], -P_right[0, 3] / P_right[0, 0]
    assert baseline == pytest.approx(np.linalg.norm(T_MM) / 1000, rel=1e-12)
    depth = f * baseline / (left - right)[:, 0]
    np.testing.assert_allclose(depth, in_view[:, 2], rtol=1e-8)
    # And P holds for both images, with points in the left camera's rectified frame.
    for P, pixels in ((P_left, left), (P_right, right)):
        u, v, w = P @ np.column_stack([in_view, np.ones(len(in_view))]).T
        np.testing.assert_allclose(np.column_stack([u / w, v / w]), pixels, atol=1e-5)


@pytest.mark.parametrize(
    ("turn", "T_mm"),
    [
        ([0.03, 0.53, -0.05], [-68.9, -0.7, 23.1]),
        ([0.03, 0.03, -0.05], [-68.9, -0.7, 3.1]),
        ([0.4, 0.03, -0.05], [2.0, -80.7, 3.1]),  # one above the other
        ([0.1, 0.2, 0.3], [40.0, 3.0, -2.0]),  # the right camera on the left
        ([0.0, 0.0, 0.0], [-72.0, 0, 0]),
        ([0.0, -2.5, 0.0], [-72.0, 0, 100.0]),
    ],
)
def test_the_rectified_frames_are_those_of_opencv(turn, T_mm):
    turned = cv2.Rodrigues(np.array(turn))[0]
    views = rectify(paper_like(0, turned, T_mm))
    R1, R2, _, P2 = cv2.stereoRectify(
        K_LEFT, None, K_RIGHT, None, SIZE, turned, np.array(T_mm)[:, None]
    )[:4]
    np.testing.assert_allclose(views.R_left, R1, rtol=0, atol=1e-9)
    np.testing.assert_allclose(views.R_right, R2, rtol=0, atol=1e-9)
    offset = P2[:, 3] / [P2[0, 0], P2[1, 1], 1]
    np.testing.assert_allclose(views.t_mm, offset, rtol=0, atol=1e-9)


def test_the_rectified_view_shows_what_the_cameras_see():
    rig = paper_like(0)
    views = rectify(rig)
    middle, shown = (np.array(SIZE) - 1) / 2, []
    for camera, turn in ((rig.left, views.R_left), (rig.right, views.R_right)):
        u, v, w = views.K @ turn @ np.append(camera.normalise(middle), 1.0)
        shown.append([u / w, v / w])
    # One principal point for two views: on average their middles stay where they were.
    np.testing.assert_allclose(np.mean(shown, axis=0), middle, atol=1e-9)
    by_opencv = cv2.stereoRectify(
        K_LEFT,
        None,
        K_RIGHT,
        None,
        SIZE,
        R,
        T_MM[:, None],
        flags=cv2.CALIB_ZERO_DISPARITY,
        alpha=-1,
    )[2]
    np.testing.assert_allclose(views.K, by_opencv[:, :3], rtol=0.05)
    assert views.K[0, 0] == pytest.approx(by_opencv[0, 0], rel=1e-12)


def test_kalibr_reads_what_is_written(tmp_path):
    rig = paper_like(4)
    write_rig(tmp_path / "camchain.yaml", rig, "kalibr")
    chain = yaml.safe_load((tmp_path / "camchain.yaml").read_text())
    assert list(chain) == ["cam0", "cam1"]
    for camera in chain.values():
        assert camera["camera_model"] == "pinhole"
        assert camera["distortion_model"] == "radtan"
        # Kalibr's reader insists on these kinds and signs.
        assert len(camera["distortion_coeffs"]) == len(camera["intrinsics"]) == 4
        assert all(isinstance(x, float) for x in camera["distortion_coeffs"] + camera["intrinsics"])
        assert min(camera["intrinsics"]) >= 0
        assert camera["resolution"] == list(SIZE)
        assert isinstance(camera["rostopic"], str)
    T_10 = np.array(chain["cam1"]["T_cn_cnm1"])
    np.testing.assert_allclose(T_10[:3, :3], R, rtol=0, atol=1e-15)
    np.testing.assert_allclose(T_10[:3, 3], T_MM / 1000, rtol=1e-13)
    np.testing.assert_array_equal(T_10[3], [0, 0, 0, 1])
    # By Kalibr's formulas: cam0's points through T_cn_cnm1, in metres, then radtan and pinhole.
    moved = np.column_stack([POINTS / 1000, np.ones(len(POINTS))]) @ T_10.T
    x, y = moved[:, 0] / moved[:, 2], moved[:, 1] / moved[:, 2]
    k1, k2, r1, r2 = chain["cam1"]["distortion_coeffs"]
    rho = x * x + y * y
    radial = 1 + k1 * rho + k2 * rho * rho
    fu, fv, pu, pv = chain["cam1"]["intrinsics"]
    u = fu * (x * radial + 2 * r1 * x * y + r2 * (rho + 2 * x * x)) + pu
    v = fv * (y * radial + 2 * r2 * x * y + r1 * (rho + 2 * y * y)) + pv
    np.testing.assert_allclose(rig.project(POINTS)[1], np.column_stack([u, v]), atol=1e-9)


def test_a_kalibr_chain_with_imu_and_topics_is_read(tmp_path):
    T_10 = np.eye(4)
    T_10[:3, :3], T_10[:3, 3] = R, T_MM / 1000
    camera = {"camera_model": "pinhole", "distortion_model": "radtan", "timeshift_cam_imu": -8e-05}
    camera |= {"T_cam_imu": np.eye(4).tolist(), "rostopic": "/cam0/image_raw", "cam_overlaps": [1]}
    chain = {
        f"cam{i}": {
            **camera,
            "distortion_coeffs": coefficients.tolist(),
            "intrinsics": [float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2])],
            "resolution": list(SIZE),
        }
        for i, (K, coefficients) in enumerate([(K_LEFT, LEFT_D[:4]), (K_RIGHT, RIGHT_D[:4])])
    }
    chain["cam1"]["T_cn_cnm1"] = T_10.tolist()
    (tmp_path / "camchain.yaml").write_text(yaml.safe_dump(chain))
    assert_same_rig(read_rig(tmp_path / "camchain.yaml"), paper_like(4))
    chain["cam0"] |= {"distortion_model": "none", "distortion_coeffs": []}
    (tmp_path / "camchain.yaml").write_text(yaml.safe_dump(chain))
    assert read_rig(tmp_path / "camchain.yaml").left.distortion == ()


def test_the_json_says_it_in_plain_keys(tmp_path):
    write_rig(tmp_path / "rig.json", paper_like(5, right_size=(640, 480)))
    rig = json.loads((tmp_path / "rig.json").read_text())
    assert (rig["format"], rig["version"]) == ("simtip-rig", 1)
    assert rig["K_left"] == K_LEFT.tolist()
    assert rig["D_right"] == RIGHT_D.tolist()
    assert (rig["size_left"], rig["size_right"]) == (list(SIZE), [640, 480])
    np.testing.assert_allclose(rig["R"], np.transpose(R), rtol=0, atol=1e-15)
    np.testing.assert_allclose(rig["T_mm"], -np.transpose(R) @ T_MM, rtol=1e-13)
    # More keys, such as a calibration's statistics, do no harm.
    (tmp_path / "more.json").write_text(json.dumps(rig | {"rms_px": {"left": 0.05}}))
    assert_same_rig(read_rig(tmp_path / "more.json"), paper_like(5, right_size=(640, 480)))


def test_a_ros_pair_under_other_names_is_read(tmp_path):
    write_ros_by_opencv(tmp_path, names=("cam_LEFT_info.yml", "cam_RIGHT_info.yml"))
    for name in ("cam_LEFT_info.yml", "cam_RIGHT_info.yml", ""):
        assert_sees_as_opencv(read_rig(tmp_path / name))
