"""Does the background's light map lie where the lamps and the needle put it?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip.geometry import Array, Pose
from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.spec import SceneSpec

NEEDLE_Z_MM = 250.0
BOARD_Z_MM = 260.0
NEEDLE_MM = (-10.0, 0.0)
"""x and y of the axis, of which the one across the needle counts."""
LAMP_MM = (-800.0, -600.0)
"""Across the needle, and z."""
STEP_MM = 0.5
WINDOW_PX = 60
BIAS_STEPS = 0.15
"""Seen: 0.06. Most of it is Mitsuba's ray epsilon: a shadow ray starts 0.02 mm before a board that
is 260 mm from the origin, which moves the shadow by as much towards the lamp."""


def test_a_linear_map_is_read_back_as_it_is(scene):
    with activated(choose()):
        from simtip.render.backdrop import Backdrop
        from simtip.render.board import Board
        from simtip.render.engine import mi
        from simtip.render.lightmap import Grid, LightMap

        # Slopes of 1 per step in s and in t: an error is read off in steps.
        fine = Grid(np.array([-31.0, 17.0]), STEP_MM, 41, 23)
        coarse = Grid(np.array([-400.0, -400.0]), 10.0, 81, 81)
        slopes = [
            (grid.points() / grid.step).reshape(grid.rows, grid.columns, 2).astype(np.float32)
            for grid in (fine, coarse)
        ]
        maps = tuple(
            LightMap(grid, values, *2 * [np.zeros_like(values)])
            for grid, values in zip((fine, coarse), slopes, strict=True)
        )
        board = Board.of(scene.background)
        rng = np.random.default_rng(5)
        reach = STEP_MM * np.array([fine.columns - 1, fine.rows - 1])
        within = fine.corner + rng.uniform(0, 1, (500, 2)) * reach
        beyond = rng.uniform(-390, 390, (500, 2))
        far = np.any((beyond < fine.corner - 1) | (beyond > fine.corner + reach + 1), axis=1)
        beyond = beyond[far]
        for st, grid in ((within, fine), (beyond, coarse)):
            points = board.points(st).astype(np.float32)
            found, _ = Backdrop(board, np.ones(3), maps).gray(
                mi.Point3f(*(mi.Float(np.ascontiguousarray(c)) for c in points.T)), mi.Mask(True)
            )
            # A GPU's texture units interpolate in steps of 1/256.
            read = np.stack([f.numpy() for f in found], axis=1)
            np.testing.assert_allclose(read, st / grid.step, rtol=0, atol=5e-3)


def beside_a_lamp(scene: SceneSpec, along: int) -> SceneSpec:
    """A needle close to the board, parallel to its only lamp, along the world's x (0) or y (1)."""
    across = 1 - along
    axis, tip, lamp = np.zeros(3), np.zeros(3), np.zeros(3)
    axis[along] = 1
    tip[along], tip[across], tip[2] = -75, NEEDLE_MM[across], NEEDLE_Z_MM
    lamp[across], lamp[2] = LAMP_MM
    data = scene.model_dump(mode="json")
    data["needle"].update(axis=axis.tolist(), tip_mm=tip.tolist())
    data["background"].update(centre_mm=[-20, 0, BOARD_Z_MM], normal=[0, 0, -1])
    data["lamps"] = [
        {"name": "lamp", "kind": "tube", "centre_mm": lamp.tolist(), "direction": axis.tolist()}
    ]
    data["lamps"][0]["diameter_mm"] = 38  # a penumbra of 0.6 mm, which the grid can follow
    data["ambient"]["radiance_w_m2_sr"] = [0, 0, 0]
    data["render"]["light_step_mm"] = STEP_MM
    return SceneSpec.model_validate(data)


def shadow_edges_mm(needle_mm: float, radius_mm: float) -> Array:
    """Where the two tangents from the tube's axis to the needle meet the board, by plane geometry.

    Lamp and needle are parallel, so one plane across them tells all. The light is half there.
    """
    to_needle = np.array([needle_mm - LAMP_MM[0], NEEDLE_Z_MM - LAMP_MM[1]])
    half_angle = np.arcsin(radius_mm / np.hypot(*to_needle))
    angle = np.arctan2(*to_needle) + np.array([-half_angle, half_angle])
    return LAMP_MM[0] + (BOARD_Z_MM - LAMP_MM[1]) * np.tan(angle)


def on_board(rays: Array, T_wc: Pose) -> Array:
    """World x and y (..., 2) where camera rays (..., 3) meet the board."""
    directions = T_wc.rotate(rays)
    return T_wc.t[:2] + directions[..., :2] * ((BOARD_Z_MM - T_wc.t[2]) / directions[..., 2:])


@pytest.mark.parametrize("along", [0, 1], ids=["level", "upright"])
def test_a_shadow_lies_where_plane_geometry_says(scene, along):
    across = 1 - along
    spec = beside_a_lamp(scene, along)
    edges = shadow_edges_mm(NEEDLE_MM[across], spec.needle.diameter_mm / 2)
    middle = np.zeros(3)
    middle[across], middle[2] = edges.mean(), BOARD_Z_MM
    rig = spec.rig.rig()
    data = spec.model_dump(mode="json")
    for side, pixel in zip(("left", "right"), rig.project(middle), strict=True):
        corner = np.rint(pixel).astype(int) - WINDOW_PX // 2
        data["rig"][side]["roi"] = [*corner.tolist(), WINDOW_PX, WINDOW_PX]
    spec = SceneSpec.model_validate(data)
    rig = spec.rig.rig()
    cameras = (rig.left, Pose.identity()), (rig.right, rig.T_lr)
    for view, (camera, T_wc) in zip(render_pair(spec), cameras, strict=True):
        assert not view.coverage.any()
        v, u = np.mgrid[:WINDOW_PX, :WINDOW_PX]
        xy = on_board(camera.rays(np.stack([u, v], axis=-1)), T_wc)
        light = view.response[0, :, :, 1].astype(float)
        if across == 1:  # integrate along columns then
            xy, light = xy.transpose(1, 0, 2), light.T
        place = xy[..., across] - edges.mean()
        # What there would be without the needle: straight over these few millimetres.
        clear = np.abs(place) > np.ptp(edges) / 2 + 1
        slopes = np.concatenate([np.ones((*light.shape, 1)), xy], axis=-1)
        plain = slopes @ np.linalg.lstsq(slopes[clear], light[clear], rcond=None)[0]
        depth = np.where(clear, 0, 1 - light / plain)
        assert depth.max() > 0.99
        moment, area = (np.trapezoid(f, place, axis=1) for f in (depth * place, depth))
        centre, width = moment / area, np.abs(area)
        assert abs(centre.mean()) < BIAS_STEPS * STEP_MM
        assert width.mean() == pytest.approx(np.ptp(edges), abs=BIAS_STEPS * STEP_MM)
