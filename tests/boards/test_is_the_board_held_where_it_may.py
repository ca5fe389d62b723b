"""Do the poses keep what `boards.poses` promises, and spread over both images?"""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from boards.board_scenes import cameras, changed, lens

from simtip.errors import InputError
from simtip.geometry import Pose, unit
from simtip.plate_poses import plate_poses
from simtip.spec import SceneSpec

pytestmark = pytest.mark.slow

VIEWS = 20
GLASS = {"f_number": 1.4, "focal_length_mm": 6.0, "focus_mm": 170.0}


def held(scene: SceneSpec, views: int = VIEWS, seed: int = 1, **boards: dict) -> tuple:
    spec = changed(scene, boards=boards)
    plate = spec.boards.build()
    return spec, plate, plate_poses(spec, plate, views, seed)


def rims(T_wt: Pose, low: np.ndarray, high: np.ndarray, plate: dict) -> np.ndarray:
    """Points (n, 3) all over the plate's faces, world: worked out here from what the scene says."""
    at = np.stack(np.meshgrid(*np.linspace(low, high, 21).T), axis=-1).reshape(-1, 2)
    off = at - (low + high) / 2
    z = plate.get("bow_mm", 0) * (off**2).sum(axis=1) / (((high - low) / 2) ** 2).sum()
    front = np.column_stack([at, z])
    back = front + np.array([0, 0, plate.get("thickness_mm", 3.0)])
    return np.concatenate([front, back]) @ T_wt.R.T + T_wt.t


CASES = {
    "as it comes": {},
    "thick and bowed back": {
        "plate": {"bow_mm": -15, "thickness_mm": 5, "print_scale": [1.02, 0.97]},
        "poses": {
            "distance_mm": 248,
            "depth_mm": 10,
            "tilt_deg": [0, 10],
            "margin_px": 9,
            "max_blur_px": 20,
        },
    },
    "steep": {
        "target": "circles:8x5:5:3",
        "poses": {"tilt_deg": [40, 60], "roll_deg": 170, "max_blur_px": 6, "margin_px": 0},
    },
}


@pytest.mark.parametrize(
    "name",
    ["as it comes", *(pytest.param(name, marks=pytest.mark.slow) for name in list(CASES)[1:])],
)
def test_every_view_keeps_to_the_limits(scene, name):
    spec, plate, poses = held(lens(scene, GLASS, GLASS), views=40, **CASES[name])
    wrong, asked = CASES[name].get("plate", {}), spec.boards.poses
    distance = asked.distance_mm or 170.0
    T_wr = spec.rig.rig().T_lr
    forward = unit(np.array([0, 0, 1]) + T_wr.R[:, 2])
    for T_wt in poses:
        np.testing.assert_allclose(T_wt.R @ T_wt.R.T, np.eye(3), atol=1e-12)
        middle = T_wt.apply([*(plate.low + plate.high) / 2, 0.0])
        assert abs(middle[2] - distance) <= asked.depth_mm + 1e-9
        tilt = np.degrees(np.arccos(T_wt.R[:, 2] @ forward))
        assert asked.tilt_deg[0] - 1e-6 <= tilt <= asked.tilt_deg[1] + 1e-6
        points = rims(T_wt, plate.low, plate.high, wrong)
        assert points[:, 2].max() < 260.1  # the background
        for (camera, T_cw), eye in zip(cameras(spec), (np.zeros(3), T_wr.t), strict=True):
            rvec = cv2.Rodrigues(T_cw.R)[0]
            pixels = cv2.projectPoints(points, rvec, T_cw.t, camera.K, None)[0].reshape(-1, 2)
            assert pixels.min() >= asked.margin_px - 0.5
            assert (pixels <= np.array(camera.size) - 0.5 - asked.margin_px).all()
            assert unit(middle - eye) @ T_wt.R[:, 2] > 0.34
            z = T_cw.apply(T_wt.apply(plate.points))[:, 2]
            blur = camera.K[:2, :2].max() * 6 / 1.4 * np.abs(1 / z - 1 / 170)
            assert blur.max() <= asked.max_blur_px + 1e-9


def test_they_spread_over_both_images_and_every_way(scene):
    spec, plate, poses = held(lens(scene, GLASS, GLASS))
    for camera, T_cw in cameras(spec):
        pixels = np.concatenate([camera.project(T_cw.apply(T.apply(plate.points))) for T in poses])
        low, high = pixels.min(axis=0) / camera.size, pixels.max(axis=0) / camera.size
        assert (low < 0.25).all()
        assert (high > 0.75).all()
        cells = np.histogram2d(*(pixels / camera.size).T, bins=6, range=[[0, 1], [0, 1]])[0]
        assert (cells > 0).mean() > 0.7
    middles = np.array([T.apply(plate.middle) for T in poses])
    assert np.ptp(middles[:, 2]) > 15
    ways = np.array([T.R[:2, 2] - np.mean([P.R[:2, 2] for P in poses], axis=0) for T in poses])
    quarters = {(bool(x > 0), bool(y > 0)) for x, y in ways}
    assert len(quarters) == 4


def test_they_are_spread_better_than_by_chance(scene):
    """The first of the pool would be by chance; few views are where choosing counts."""
    spec, plate, chosen = held(scene, views=6)

    def cells(poses: list[Pose]) -> int:
        seen = 0
        for camera, T_cw in cameras(spec):
            at = np.concatenate([camera.project(T_cw.apply(T.apply(plate.points))) for T in poses])
            seen += len(np.unique((at / camera.size * 8).astype(int), axis=0))
        return seen

    many = plate_poses(spec, plate, 32, 1)
    rng = np.random.default_rng(0)
    by_chance = [cells([many[k] for k in rng.choice(32, 6, replace=False)]) for _ in range(20)]
    assert cells(chosen) > np.mean(by_chance)


def test_the_seed_decides_and_more_views_begin_alike(scene):
    _, _, few = held(scene, views=3, seed=5)
    _, _, more = held(scene, views=12, seed=5)
    _, _, other = held(scene, views=3, seed=6)
    for a, b in zip(few, more, strict=False):
        np.testing.assert_array_equal(a.R, b.R)
        np.testing.assert_array_equal(a.t, b.t)
    assert not np.allclose(few[0].t, other[0].t)
    spots = np.array([T.t for T in more])
    assert len(np.unique(spots, axis=0)) == 12


@pytest.mark.parametrize(
    ("boards", "named"),
    [
        ({"target": "chessboard:11x8:30"}, "leaves the left image"),
        ({"poses": {"distance_mm": 258, "depth_mm": 0}}, "reaches into the background"),
        ({"poses": {"distance_mm": 100, "depth_mm": 1}, "target": "chessboard:3x3:2"},
         "is out of focus"),
        ({"poses": {"distance_mm": 5, "depth_mm": 0}, "target": "chessboard:2x2:0.1"},
         "is not before the"),
    ],
)  # fmt: skip
def test_too_few_say_what_most_failed_by(scene, boards, named, monkeypatch):
    monkeypatch.setattr("simtip.plate_poses.CANDIDATES", 1024)
    with pytest.raises(InputError) as error:
        held(lens(scene, GLASS, GLASS), views=20, **boards)
    assert "\n" not in str(error.value)
    assert error.value.field == "boards.poses"
    assert " of 20 views fit" in error.value.problem
    assert named in error.value.problem
    assert error.value.remedy.startswith("try ")
