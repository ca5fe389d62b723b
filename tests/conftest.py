from __future__ import annotations

import gc
import os
import signal
import sys
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path

# No test multiplies large matrices: more threads only wait for each other, and for other workers.
# Read when NumPy is loaded, and handed on to every process that a test starts.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell's background jobs ignore SIGINT, and so would all that tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

import numpy as np
import pytest
import typer.main
from asked import call
from regions import with_roi

from simtip.camera import Camera, StereoRig
from simtip.errors import InputError
from simtip.geometry import Pose, nearest_rotation
from simtip.render.backend import choose
from simtip.scene_file import load_scene
from simtip.spec import SceneSpec
from simtip.yaml_file.compose import Composer

# For the tests of the plug-in: pytest takes this from the outermost folder of tests only.
pytest_plugins = ["pytester"]

# The command line is built anew for every call, which takes longer than most of what is asked.
typer.main.get_command = cache(typer.main.get_command)

# So it is with parsing the same few scenes and suites; what is made of the nodes is made anew.
_compose = Composer.compose


@lru_cache(maxsize=256)
def _composed(text, opencv):
    return _compose(Composer("", opencv=opencv), text)


def _compose_once(composer, text):
    """Compose a file unless it is known; what is wrong with it is said of the file itself."""
    if len(text) < 20_000:
        with suppress(InputError):
            return _composed(text, composer.opencv)
    return _compose(composer, text)


Composer.compose = _compose_once

# Until all tests are collected nothing is garbage, and then they need not be looked through again.
gc.disable()

ROOT = Path(__file__).resolve().parents[1]


def pytest_collection_finish():
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def scene_path() -> Path:
    """The paper's set-up."""
    return ROOT / "scenes" / "01_single_tip.yaml"


@pytest.fixture(scope="session")
def paper_rig() -> StereoRig:
    """Table 1, typed here again so that the scene file is not its own witness."""
    left = np.array([[1909.84, 0, 932.97], [0, 1910.22, 657.90], [0, 0, 1]])
    right = np.array([[1923.38, 0, 935.88], [0, 1914.32, 729.04], [0, 0, 1]])
    R = [[0.862, -0.020, -0.507], [0.036, 0.999, 0.022], [0.506, -0.037, 0.861]]
    pose = Pose(nearest_rotation(R), np.array([72.047, 2.138, 14.041]))
    return StereoRig(Camera(left, 2048, 1436), Camera(right, 2048, 1436), pose)


@pytest.fixture(scope="session")
def scene(scene_path) -> SceneSpec:
    """The paper's set-up at full size."""
    return load_scene(scene_path)


@pytest.fixture(scope="session")
def small_scene(scene) -> SceneSpec:
    """The paper's set-up, read out only around the tip: the same rays, fewer of them."""
    return with_roi(scene, [780, 800, 80, 100], [990, 795, 80, 100], noise=None, samples=256)


@pytest.fixture(scope="session")
def table_1(paper_rig) -> StereoRig:
    """The same, by the name that tests of the measuring wing use."""
    return paper_rig


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


@pytest.fixture
def ask():
    """Call the command line in this process."""
    return call


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown():
    """Leave the renderer as tests want it, once one has loaded it.

    After a scalar render there is no back end set that every later render has to go back to. Where
    every core has a worker of pytest-xdist, Dr.Jit's threads wait for work, and that is a third of
    what small renders cost.
    """
    drjit = sys.modules.get("drjit")
    if drjit is not None and "PYTEST_XDIST_WORKER" in os.environ and drjit.thread_count() != 1:
        drjit.set_thread_count(1)
    mitsuba = sys.modules.get("mitsuba")
    if mitsuba is not None and str(mitsuba.variant()).startswith("scalar"):
        mitsuba.set_variant(choose().variant)
