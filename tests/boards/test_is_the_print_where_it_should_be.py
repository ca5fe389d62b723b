"""Rendered pixel by pixel against photographs worked out without the renderer, in both cameras."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest
from boards.board_scenes import cameras, changed, even, lens, regions_at
from oracles.board_photograph import Photographer, charuco, chessboard, circles, pose

from simtip.camera import Camera
from simtip.geometry import Pose
from simtip.render import View, render_board
from simtip.spec import SceneSpec

pytestmark = pytest.mark.slow

SHIFT_PX = 0.003
SIZE = 90
BENT = (-0.12, 0.05, 0.001, -0.0008, 0.01)
BARE, INK = 0.75, 0.05

Ink = Callable[[np.ndarray, np.ndarray], np.ndarray]
Photograph = Callable[[Camera], np.ndarray]


def rendered(
    spec: SceneSpec, T_wt: Pose, at: list, samples: int = 64
) -> tuple[SceneSpec, tuple[View, View]]:
    """Render about board points `at`, one for each camera."""
    plate = spec.boards.build()
    points = [T_wt.apply(plate.surface(np.array([point]))[0]) for point in at]
    crop = changed(regions_at(spec, points, SIZE), render={"noise": None, "samples": samples})
    return crop, render_board(crop, plate, T_wt)


def coverage(view: View) -> np.ndarray:
    """Give how much of each pixel is inked: in an even light it alone decides."""
    return (BARE - view.response[-1].mean(axis=2)) / (BARE - INK)


def shift(found: np.ndarray, camera: Camera, photograph: Photograph) -> np.ndarray:
    """Give how far (u, v) a picture lies to the right of and below a photograph, px."""
    h = 0.1
    right, left, down, up = (
        photograph(replace(camera, K=camera.K + np.array([[0, 0, du], [0, 0, dv], [0, 0, 0]])))
        for du, dv in [(h, 0), (-h, 0), (0, h), (0, -h)]
    )
    slopes = np.stack([(right - left).ravel(), (down - up).ravel()], axis=1) / (2 * h)
    slopes = np.column_stack([slopes, np.ones(len(slopes))])
    off = (found - photograph(camera)).ravel()
    return np.linalg.lstsq(slopes, off, rcond=None)[0][:2]


def board_scene(scene: SceneSpec, target: str, distortion: tuple = (), **plate: object):
    looks = {"albedo": [BARE] * 3, "ink_albedo": [INK] * 3, "edge_blur_mm": 0}
    with_lens = {"distortion": list(distortion)}
    spec = lens(even(scene), with_lens, with_lens)
    return changed(spec, boards={"target": target, "plate": looks | plate})


def scaled(ink: Ink, x: float, y: float) -> Ink:
    return lambda s, t: ink(s / x, t / y)


LATTICE = np.stack(np.meshgrid(np.arange(11), np.arange(8)), axis=-1).reshape(-1, 2) * 6.0
BY_TURNS = np.array([(2 * i + j % 2, j) for j in range(11) for i in range(4)]) * 5.0

CASES = {
    "chessboard": ("chessboard:11x8:6", chessboard(11, 8, 6.0), (), (1.01, 0.985)),
    "charuco, distorted": ("charuco:7x5:6:4.5", charuco(7, 5, 6.0, 4.5), BENT, (0.99, 1.02)),
    "circles, distorted": ("circles:11x8:6:3", circles(LATTICE, 3.0), BENT, (1.0, 1.0)),
    "asymmetric": ("asymmetric:4x11:5:4", circles(BY_TURNS, 4.0), (), (1.01, 1.0)),
}
FAST = ("charuco, distorted",)


@pytest.mark.parametrize(
    "name",
    [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in CASES],
)
def test_a_print_lies_where_a_photograph_has_it(scene, name):
    target, ink, distortion, scale = CASES[name]
    spec = board_scene(scene, target, distortion, print_scale=list(scale))
    # A board far off the axes, so that scale and distortion tell.
    rvec, t = pose(18, 40, 9, np.array([20.0, 15.0]), np.array([-2.0, 12.0, 165.0]))
    T_wt = Pose(cv2.Rodrigues(rvec)[0], t)
    samples = 64 if name in FAST else 512  # circles have less edge to tell a shift by
    crop, views = rendered(spec, T_wt, [(30.0, 18.0), (3.0, 4.0)], samples)
    for view, (camera, T_cw) in zip(views, cameras(crop), strict=True):
        photograph = partial(photographed, ink=scaled(ink, *scale), T_ct=T_cw @ T_wt)
        expected = photograph(camera)
        assert 0.1 < expected.mean() < 0.8
        found = coverage(view)
        np.testing.assert_allclose(shift(found, camera, photograph), 0, atol=SHIFT_PX)
        # The raster's softness, a tenth of a pixel, lightens and darkens beside an edge.
        np.testing.assert_allclose(found, expected, atol=0.08)
        assert abs((found - expected).mean()) < 3e-4


def photographed(camera: Camera, ink: Ink, T_ct: Pose) -> np.ndarray:
    """Give how much of each pixel a flat print inks."""
    distortion = np.array(camera.distortion or np.zeros(5))
    box = np.array([[-8.0, -8.0], [80.0, 70.0]])
    oracle = Photographer(camera.K, camera.size, distortion)
    return oracle.coverage(ink, box, cv2.Rodrigues(T_ct.R)[0], T_ct.t)


def bowed(camera: Camera, T_ct: Pose, ink: Ink, bow: float, middle: list, half: list) -> np.ndarray:
    """Meet each ray with the paraboloid z = bow |st - middle|^2 / |half|^2 by its quadratic."""
    n = 12
    row, column = np.indices((n, n)) + 0.5
    du, dv = (column + row / n - 0.5) / n - 0.5, (row + column / n - 0.5) / n - 0.5
    v, u = np.mgrid[: camera.height, : camera.width]
    u, v = u[..., None] + du.ravel(), v[..., None] + dv.ravel()
    (fx, _, cx), (_, fy, cy), _ = camera.K
    d = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones_like(u)], axis=-1) @ T_ct.R
    o = -T_ct.R.T @ T_ct.t
    k = bow / (half[0] ** 2 + half[1] ** 2)
    x, y = o[0] - middle[0], o[1] - middle[1]
    a = k * (d[..., 0] ** 2 + d[..., 1] ** 2)
    b = 2 * k * (x * d[..., 0] + y * d[..., 1]) - d[..., 2]
    c = k * (x**2 + y**2) - o[2]
    distance = 2 * c / (-b + np.sqrt(b**2 - 4 * a * c))
    return ink(o[0] + distance * d[..., 0], o[1] + distance * d[..., 1]).mean(axis=-1)


@pytest.mark.parametrize("bow", [3.0, pytest.param(-3.0, marks=pytest.mark.slow)])
def test_a_bowed_print_lies_where_rays_meet_a_paraboloid(scene, bow):
    spec = board_scene(scene, "chessboard:11x8:6", bow_mm=bow, print_scale=[1.0, 1.01])
    rvec, t = pose(35, 70, -5, np.array([20.0, 15.0]), np.array([-2.0, 12.0, 165.0]))
    T_wt = Pose(cv2.Rodrigues(rvec)[0], t)
    crop, views = rendered(spec, T_wt, [(55.0, 40.0), (3.0, 4.0)])
    # 12 x 9 squares of 6 mm from (-6, -6), 1 % too long in y, and 6 mm of margin.
    middle, half = [30.0, 21.0 * 1.01], [36.0 + 6, 27.0 * 1.01 + 6]
    ink = scaled(chessboard(11, 8, 6.0), 1.0, 1.01)
    for view, (camera, T_cw) in zip(views, cameras(crop), strict=True):
        photograph = partial(bowed, T_ct=T_cw @ T_wt, ink=ink, bow=bow, middle=middle, half=half)
        expected = photograph(camera)
        flat = photograph(camera, bow=0.0)
        assert np.abs(flat - expected).max() > 0.9
        np.testing.assert_allclose(shift(coverage(view), camera, photograph), 0, atol=SHIFT_PX)
        np.testing.assert_allclose(coverage(view), expected, atol=0.09)


def test_the_measure_of_a_shift_can_tell():
    K = np.array([[1900.0, 0, 50], [0, 1900, 50], [0, 0, 1]])
    off = np.array([[0, 0, 0.01], [0, 0, -0.02], [0, 0, 0]])
    camera, moved = Camera(K, 100, 100), Camera(K + off, 100, 100)
    rvec, t = pose(18, 40, 9, np.array([20.0, 15.0]), np.array([0, 0, 165.0]))
    T_ct = Pose(cv2.Rodrigues(rvec)[0], t)
    photograph = partial(photographed, ink=chessboard(11, 8, 6.0), T_ct=T_ct)
    found = shift(photograph(moved), camera, photograph)
    np.testing.assert_allclose(found, [0.01, -0.02], atol=5e-4)
