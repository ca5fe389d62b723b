"""Are prints, gradients and wrinkles read at the right place of the board, by both cameras?"""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from regions import with_roi

from simtip.clutter import BoardTexture
from simtip.clutter.prints import Print, strewn
from simtip.geometry import Pose, unit
from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.spec import SceneSpec

CENTRE = np.array([-20.0, 0.0, 260.0])
SIDE = 56
CENTROID_PX = 0.02


def bare(scene: SceneSpec, rois: list[list[int]], **more: object) -> SceneSpec:
    """The board in ambient light, the needle far from it."""
    data = with_roi(scene, *rois, light_step_mm=2).model_dump(mode="json")
    data["needle"]["tip_mm"] = [-10, 5000, 170]
    data["lamps"] = []
    data["ambient"]["radiance_w_m2_sr"] = [1, 1, 1]
    data["background"] |= more.pop("background", {})
    return SceneSpec.model_validate(data | more)


def on_board(st: np.ndarray) -> np.ndarray:
    """World points (..., 3) of board coordinates: s runs left in the left image, t down."""
    return CENTRE + np.stack([-st[..., 0], st[..., 1], np.zeros(st.shape[:-1])], axis=-1)


def opencv_pixels(scene: SceneSpec, points: np.ndarray, side: int) -> np.ndarray:
    rig = scene.rig.rig()
    camera = (rig.left, rig.right)[side]
    T_cw = (Pose.identity(), rig.T_lr.inverse())[side]
    found, _ = cv2.projectPoints(points.reshape(-1, 1, 3), cv2.Rodrigues(T_cw.R)[0], T_cw.t,
                                 camera.K, None)  # fmt: skip
    return found.reshape(-1, 2)


def rois_at(scene: SceneSpec, point: np.ndarray, size: int = SIDE) -> list[list[int]]:
    corners = [np.rint(opencv_pixels(scene, point, k)[0] - size / 2).astype(int) for k in (0, 1)]
    return [[int(u), int(v), size, size] for u, v in corners]


def area_and_centroid(outline: np.ndarray) -> tuple[float, np.ndarray]:
    after = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0]
    return cross.sum() / 2, ((outline + after) * cross[:, None]).sum(axis=0) / (3 * cross.sum())


def lonely_specks(spec: SceneSpec, count: int) -> list[Print]:
    """Specks of some size that nothing else comes near."""
    prints = list(strewn(spec.clutter.amounts(), spec.seed, np.full(2, -40.0), np.full(2, 40.0)))
    middles = np.array([p.outline.mean(axis=0) for p in prints])
    found = []
    for item, middle in zip(prints, middles, strict=True):
        apart = np.sort(np.linalg.norm(middles - middle, axis=1))[1]
        near = np.abs(middle).max() < 35
        if near and item.kind == "speck" and 0.6 < np.sqrt(item.area_mm2) < 1.6 and apart > 8:
            found.append(item)
    assert len(found) >= count
    return found[:count]


@pytest.mark.parametrize("number", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2))])
def test_a_speck_is_printed_where_opencv_projects_it(scene, number, monkeypatch):
    clutter = {"level": "none", "specks_per_100cm2": 40.0, "speck_mm": 0.8, "contrast": [0.5, 0.5]}
    spec = bare(scene, [[0, 0, 8, 8]] * 2, clutter=clutter)
    speck = lonely_specks(spec, 3)[number]
    middle = on_board(speck.outline.mean(axis=0))
    rois = rois_at(spec, middle)
    with activated(choose()):
        from simtip.render import look

        monkeypatch.setattr(look, "PAPER_SAMPLES", 64)  # or chance alone moves it by 0.02 px
        views = render_pair(bare(scene, rois, clutter=clutter))
    v, u = np.mgrid[:SIDE, :SIDE]
    for k, view in enumerate(views):
        outline = opencv_pixels(spec, on_board(speck.outline), k) - rois[k][:2]
        area, centroid = area_and_centroid(outline)
        seen = view.clutter
        assert seen.sum() == pytest.approx(abs(area), rel=0.01)
        at = np.array([(u * seen).sum(), (v * seen).sum()]) / seen.sum()
        np.testing.assert_allclose(at, centroid, rtol=0, atol=CENTROID_PX)
        # The mask tells what the picture shows.
        dark = 1 - view.response[-1].mean(axis=2) / 0.8
        np.testing.assert_allclose(dark, 0.5 * seen, rtol=0, atol=2e-3)


def test_a_gradient_is_read_at_its_place(scene):
    """Its texels are 2 mm wide: half a one would be 7 % off."""
    place = on_board(np.array([3.0, -4.0]))
    rois = rois_at(scene, place, 40)
    gradient = {"kind": "linear", "ratio": 0.2, "direction_deg": 35, "span_mm": 20}
    background = {"albedo": [0.5, 0.5, 0.5], "gradient": gradient}
    spec = bare(scene, rois, background=background)
    rig = spec.rig.rig()
    swing = (0.2 - 1) / (0.2 + 1)
    for view, camera, T_wc in zip(
        render_pair(spec), (rig.left, rig.right), (Pose.identity(), rig.T_lr), strict=True
    ):
        v, u = np.mgrid[:40, :40]
        d = T_wc.rotate(camera.rays(np.stack([u, v], axis=-1)))
        points = T_wc.t + d * ((260 - T_wc.t[2]) / d[..., 2])[..., None]
        s, t = CENTRE[0] - points[..., 0], points[..., 1] - CENTRE[1]
        x = (s * np.cos(np.radians(35)) + t * np.sin(np.radians(35))) / 10
        straight = np.abs(x) < 0.75  # beyond, texels straddle the kink where it grows constant
        assert straight.sum() > 500
        expected = 0.5 * (1 + swing * x)
        off = (view.response[-1].mean(axis=2) / expected - 1)[straight]
        assert np.abs(off).max() < 0.02
        assert abs(off.mean()) < 5e-4


def test_wrinkles_tilt_the_paper_by_the_cosine(scene):
    """Against n'.l / n.l with the normals at the four nearest grid points, in numpy."""
    rng = np.random.default_rng(4)
    corner, step, shape = np.array([-7.0, 3.0]), 0.8, (13, 17)
    slope = rng.normal(0, 0.4, (*shape, 2)).astype(np.float32)
    lamps = np.array([[300.0, -900, -200], [-400.0, 100, -100]])
    with activated(choose()):
        from simtip.render.backdrop import Backdrop
        from simtip.render.board import Board
        from simtip.render.engine import mi
        from simtip.render.lightmap import Grid, LightMap

        data = scene.model_dump(mode="json")
        data["background"]["normal"] = [0.2, -0.1, -1]
        board = Board.of(SceneSpec.model_validate(data).background)
        even = np.ones((81, 81, 3), np.float32)
        level = LightMap(Grid(np.full(2, -400.0), 10.0, 81, 81), even, 0 * even, 0 * even)
        plain = np.ones((4, 4), np.float32)
        texture = BoardTexture(
            corner_mm=np.array([-100.0, -100.0]), step_mm=50.0, albedo=plain, clutter=0 * plain,
            slope=slope, slope_corner_mm=corner, slope_step_mm=step, prints={},
        )  # fmt: skip
        backdrop = Backdrop(board, np.ones(3), (level, level), texture, tuple(lamps))
        at = rng.uniform(0.01, 0.99, (400, 2)) * (np.array(shape[::-1]) - 1)
        points = board.points(corner + step * at).astype(np.float32)
        found, _ = backdrop.gray(mi.Point3f(*(mi.Float(c.copy()) for c in points.T)), mi.Mask(True))
        shade = np.stack([f.numpy() for f in found[:2]], axis=1)
        np.testing.assert_allclose(
            found[2].numpy(), 1, rtol=1e-6
        )  # the ambient comes from everywhere
        off_grid = board.points(corner - 3.0)
        found, _ = backdrop.gray(mi.Point3f(off_grid.tolist()), mi.Mask(True))
        np.testing.assert_allclose([f.numpy() for f in found], 1, rtol=1e-6)
    i, j = np.floor(at).astype(int).T
    fu, fv = (at - np.floor(at)).T[:, :, None]
    ds, dt = (
        slope[j, i] * (1 - fu) * (1 - fv) + slope[j, i + 1] * fu * (1 - fv)
        + slope[j + 1, i] * (1 - fu) * fv + slope[j + 1, i + 1] * fu * fv
    ).T  # fmt: skip
    normals = unit(board.normal - ds[:, None] * board.x - dt[:, None] * board.y)
    towards = np.stack([unit(lamp - points.astype(float)) for lamp in lamps], axis=1)
    expected = np.einsum("ni,nki->nk", normals, towards).clip(0) / (towards @ board.normal)
    assert (expected == 0).any()
    assert expected.max() > 1.1
    # A GPU's texture units interpolate in steps of 1/256.
    np.testing.assert_allclose(shade, expected, rtol=0, atol=2e-2 * expected.max())
    assert np.abs(shade - expected).mean() < 2e-3
