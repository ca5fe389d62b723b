"""Rigs to write and read, and how they are compared."""

import cv2
import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose

SETTINGS = settings(derandomize=True, deadline=None, max_examples=40)
SIZE = (2048, 1436)

K_LEFT = np.array([[1909.84, 0, 932.97], [0, 1910.22, 657.9], [0, 0, 1]])
K_RIGHT = np.array([[1923.38, 0, 935.88], [0, 1914.32, 729.04], [0, 0, 1]])
D = (-0.11, 0.13, 1e-3, -2e-4, 0.02, 1e-5, -3e-3, 4e-4, 1e-6, 2e-6, 3e-6, 4e-6, 1e-3, -2e-3)
R = cv2.Rodrigues(np.array([0.03, 0.53, -0.05]))[0]
T_MM = np.array([-68.9, -0.7, 23.1])
"""As in OpenCV: p_right = R p_left + T."""

POINTS = np.array([[-10.0, 20, 170], [15, -12, 190], [0, 0, 150], [30, 25, 210]])


def paper_like(coefficients=4, R=R, T_mm=T_MM, size=SIZE, right_size=SIZE):
    """A rig like the paper's Table 1."""
    return StereoRig(
        Camera(K_LEFT, *size, D[:coefficients]),
        Camera(K_RIGHT, *right_size, tuple(0.7 * np.array(D[:coefficients]))),
        Pose(np.asarray(R), np.asarray(T_mm)).inverse(),
    )


def assert_same_rig(found, expected, tolerance=1e-12):
    """K and the sizes to the last bit; distortion too, but for zeros that mean nothing."""
    for a, b in ((found.left, expected.left), (found.right, expected.right)):
        np.testing.assert_array_equal(a.K, b.K)
        padded = [(*camera.distortion, *[0.0] * 14)[:14] for camera in (a, b)]
        assert padded[0] == padded[1]
        assert a.size == b.size
    np.testing.assert_allclose(found.T_lr.R, expected.T_lr.R, rtol=0, atol=tolerance)
    scale = np.linalg.norm(expected.T_lr.t)
    np.testing.assert_allclose(found.T_lr.t, expected.T_lr.t, rtol=0, atol=tolerance * scale)


def cameras(coefficients):
    """Any camera with so many coefficients of distortion as a list says."""
    sides = st.integers(1, 65535)
    focal, centre = st.floats(1, 1e5), st.floats(0, 1e5)
    distortion = st.sampled_from(coefficients).flatmap(
        lambda n: st.lists(st.floats(-2, 2), min_size=n, max_size=n)
    )
    return st.builds(
        lambda fx, fy, cx, cy, w, h, d: Camera(
            np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), w, h, tuple(d)
        ),
        *(focal, focal, centre, centre, sides, sides, distortion),
    )


def poses():
    """Any pose: tiny and half turns, baselines in any direction, 1 mm to 17 m."""
    angle = st.one_of(st.floats(-1.8, 1.8), st.floats(-1e-9, 1e-9), st.sampled_from([0.0, np.pi]))
    length = st.one_of(st.floats(2, 1e4), st.floats(-1e4, -2))
    along = st.one_of(st.floats(-1e4, 1e4), st.just(0.0))
    return st.builds(
        lambda turn, t, order: Pose(cv2.Rodrigues(np.array(turn))[0], np.array(t)[list(order)]),
        st.tuples(angle, angle, angle),
        st.tuples(length, along, along),
        st.permutations(range(3)),
    )


def rigs(coefficients):
    """Any rig whose cameras have so many coefficients as a list says."""
    return st.builds(StereoRig, cameras(coefficients), cameras(coefficients), poses())
