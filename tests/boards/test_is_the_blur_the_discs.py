"""Is an edge of the print out of focus as soft as the thin lens and the stated print make it?"""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from boards.board_scenes import cameras, changed, even, lens, regions_at

from simtip.geometry import Pose
from simtip.render import render_board
from simtip.render.ink import ink_raster
from simtip.target import parse_target

pytestmark = pytest.mark.slow

FOCUS_MM, F_NUMBER, FOCAL_MM = 170.0, 1.4, 6.0


def spread(profile: np.ndarray) -> tuple[float, float]:
    """Mean and variance of what an edge, sampled at whole numbers, is smeared with."""
    line = np.diff(profile) / (profile[-1] - profile[0])
    k = np.arange(len(line)) + 0.5
    mean = (k * line).sum()
    # Differences between samples are sums over bins one pixel wide.
    return mean, ((k - mean) ** 2 * line).sum() - 1 / 12


SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    ("side", "z_mm"),
    [
        (0, 190.0),
        *(pytest.param(*case, marks=SLOW) for case in [(1, 190.0), (1, 155.0), (0, 170.0)]),
    ],
)
def test_an_edge_is_smeared_by_the_disc(scene, side, z_mm):
    glass = {"f_number": F_NUMBER, "focal_length_mm": FOCAL_MM, "focus_mm": FOCUS_MM}
    spec = lens(even(scene), glass, glass)
    edge_blur = 0.1
    look = {"edge_blur_mm": edge_blur}
    spec = changed(spec, boards={"target": "chessboard:2x2:12", "plate": look})
    # Square to one camera; the vertical edge below point 0 in the middle of its picture.
    _, T_cw = cameras(spec)[side]
    T_ct = Pose(np.eye(3), np.array([-9.0, 11.0, z_mm]))
    T_wt = T_cw.inverse() @ T_ct
    at = T_wt.apply(np.array([0.0, 6.0, 0.0]))
    crop = changed(regions_at(spec, [at, at], 44), render={"noise": None, "samples": 256})
    view = render_board(crop, crop.boards.build(), T_wt)[side]
    camera = cameras(crop)[side][0]
    profile = view.response[-1].mean(axis=(0, 2))
    mean, found = spread(profile)
    fx = camera.K[0, 0]
    blur = fx * FOCAL_MM / F_NUMBER * abs(1 / z_mm - 1 / FOCUS_MM)
    expected = blur**2 / 16 + 1 / 12 + (edge_blur * fx / z_mm) ** 2
    assert found == pytest.approx(expected, rel=0.01, abs=0.004)
    assert mean == pytest.approx(camera.project(T_ct.apply([0.0, 6.0, 0.0]))[0], abs=0.01)


@pytest.mark.parametrize("edge_blur", [0.0, 0.01, 0.013, 0.02, 0.05, 0.3])
def test_a_raster_of_squares_is_as_soft_as_stated(edge_blur):
    """Across an edge, linear between texels as the cameras read it."""
    raster = ink_raster(parse_target("chessboard:2x2:6"), edge_blur)
    line = raster.values[round((1 - raster.corner_mm[1]) / raster.step_mm)].astype(float)
    x = raster.corner_mm[0] + np.arange(len(line)) * raster.step_mm
    fine = np.arange(-2.5, 2.5, raster.step_mm / 16)
    mean, variance = spread(np.interp(fine, x, line))
    softness = np.sqrt(variance) * raster.step_mm / 16
    least = raster.step_mm / np.sqrt(12)
    assert softness == pytest.approx(max(edge_blur, least), rel=0.01)
    assert fine[0] + mean * raster.step_mm / 16 == pytest.approx(0, abs=1e-4)


@pytest.mark.parametrize("edge_blur", [0.0, 0.02, 0.1])
def test_a_raster_of_circles_is_as_soft_as_stated(edge_blur):
    """Averaged around a disc, whose edge crosses texels everyhow."""
    raster = ink_raster(parse_target("circles:2x2:6:4"), edge_blur)
    turn, out = np.linspace(0, 2 * np.pi, 720), np.linspace(1.0, 3.0, 2000)
    u, v = (
        ((out * way[:, None] - corner) / raster.step_mm).astype(np.float32)
        for way, corner in zip((np.cos(turn), np.sin(turn)), raster.corner_mm, strict=True)
    )
    line = cv2.remap(raster.values, u, v, cv2.INTER_LINEAR).mean(axis=0, dtype=float)
    mean, variance = spread(line)
    step = out[1] - out[0]
    softness = np.sqrt(variance) * step
    assert softness == pytest.approx(max(edge_blur, raster.step_mm / 2), rel=0.06)
    assert 1.0 + mean * step == pytest.approx(2.0, abs=5e-4 + edge_blur**2 / 2)
