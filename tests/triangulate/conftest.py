"""The rig of the paper's Table 1."""

import numpy as np
import pytest

from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose, nearest_rotation


@pytest.fixture(scope="session")
def table_1():
    left = Camera(np.array([[1909.84, 0, 932.97], [0, 1910.22, 657.90], [0, 0, 1]]), 2048, 1436)
    right = Camera(np.array([[1923.38, 0, 935.88], [0, 1914.32, 729.04], [0, 0, 1]]), 2048, 1436)
    R = nearest_rotation([[0.862, -0.020, -0.507], [0.036, 0.999, 0.022], [0.506, -0.037, 0.861]])
    return StereoRig(left, right, Pose(R, np.array([72.047, 2.138, 14.041])))


@pytest.fixture(scope="session")
def distorted(table_1):
    left, right = (
        Camera(c.K, c.width, c.height, k)
        for c, k in [
            (table_1.left, (-0.12, 0.05, 0.001, -0.0008, 0.01)),
            (table_1.right, (-0.10, 0.04, -0.0007, 0.0012, -0.02)),
        ]
    )
    return StereoRig(left, right, table_1.T_lr)


@pytest.fixture(scope="session")
def volume_mm():
    """Give points (216, 3) about the needle, seen by both cameras of Table 1."""
    axes = np.linspace(-50, 15, 6), np.linspace(-30, 30, 6), np.linspace(120, 230, 6)
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
