"""Does the mask show solid clutter's outline? Does its shadow fall where plane geometry says?"""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from regions import with_roi

from simtip.clutter import ClutterObject
from simtip.clutter.solids import tube
from simtip.geometry import Pose, unit
from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.spec import SceneSpec

FINE = 8
"""Pixels of the oracle's raster to a side of the picture's."""
LAMP = np.array([-60.0, -250.0, -300.0])


MIDDLE = np.array([-36.0, -4.0, 246.0])


def rod() -> ClutterObject:
    """A tapering rod 14 mm before the board, askew."""
    along = unit([1, 0.5, 0.2])
    spine = MIDDLE + np.linspace(-20, 20, 41)[:, None] * along
    vertices, faces = tube(spine, np.linspace(0.4, 1.1, 41), 48)
    return ClutterObject(
        name="rod_0", kind="rod", vertices=vertices, faces=faces, albedo=np.full(3, 0.3),
        in_view=True, finish="matt", diameter_mm=1.5,
    )  # fmt: skip


@pytest.fixture(scope="module")
def views(scene):
    corners = [np.rint(p - [50, 20]).astype(int) for p in scene.rig.rig().project(MIDDLE)]
    rois = [[int(u), int(v), 72, 88] for u, v in corners]
    data = with_roi(scene, *rois, samples=256, noise=None, light_step_mm=0.25).model_dump(
        mode="json"
    )
    data["needle"]["tip_mm"] = [-10, 5000, 170]
    data["lamps"] = [{"name": "bulb", "kind": "point", "centre_mm": LAMP.tolist()}]
    spec = SceneSpec.model_validate(data)
    with activated(choose()), pytest.MonkeyPatch.context() as monkeypatch:
        from simtip.render import pair

        monkeypatch.setattr(pair, "objects", lambda *_: (rod(),))
        with_rod = render_pair(spec)
        monkeypatch.setattr(pair, "objects", lambda *_: ())
        without = render_pair(spec)
    return spec, with_rod, without


def drawn(spec: SceneSpec, points: np.ndarray, faces: np.ndarray, side: int) -> np.ndarray:
    """(H, W) share of each pixel under projected triangles, OpenCV's rasteriser, 8 x 8 finer."""
    rig = spec.rig.rig()
    camera, T_cw = [(rig.left, Pose.identity()), (rig.right, rig.T_lr.inverse())][side]
    pixels = camera.project(T_cw.apply(points))
    corners = np.rint(((pixels + 0.5) * FINE - 0.5) * 16).astype(np.int32)
    canvas = np.zeros((camera.height * FINE, camera.width * FINE), np.uint8)
    for triangle in corners[faces]:
        cv2.fillConvexPoly(canvas, triangle, 1, shift=4)
    shape = (camera.height, FINE, camera.width, FINE)
    return canvas.reshape(shape).mean(axis=(1, 3))


def shadow(points: np.ndarray) -> np.ndarray:
    """Points (n, 3) thrown from the lamp onto the board z = 260."""
    d = points - LAMP
    return LAMP + d * ((260 - LAMP[2]) / d[:, 2])[:, None]


def grown(mask: np.ndarray, by: int) -> np.ndarray:
    return cv2.dilate(mask.astype(np.uint8), np.ones((2 * by + 1, 2 * by + 1), np.uint8)) > 0


def test_the_mask_is_the_meshs_silhouette(views):
    spec, with_rod, _ = views
    thing = rod()
    for k, view in enumerate(with_rod):
        expected = drawn(spec, thing.vertices, thing.faces, k)
        assert 300 < expected.sum() < 0.8 * expected.size
        assert view.clutter.sum() == pytest.approx(expected.sum(), rel=0.02)
        # OpenCV's polygons are half a fine pixel fat.
        assert np.abs(view.clutter - expected).max() < 0.25
        v, u = np.mgrid[: expected.shape[0], : expected.shape[1]]
        for axis in (u, v):
            centre = [(axis * mask).sum() / mask.sum() for mask in (view.clutter, expected)]
            assert centre[0] == pytest.approx(centre[1], abs=0.05)


def test_its_shadow_falls_on_the_board(views):
    spec, with_rod, without = views
    thing = rod()
    for k, (view, plain) in enumerate(zip(with_rod, without, strict=True)):
        assert not plain.clutter.any()
        dark = drawn(spec, shadow(thing.vertices), thing.faces, k)
        board = view.clutter == 0
        # The light map's steps blur the edge by 2 px.
        inside, outside = ~grown(dark < 1, 2) & board, ~grown(dark > 0, 2) & board
        assert inside.sum() > 30
        assert outside.sum() > 1000
        lit = view.response[0].mean(axis=2) / plain.response[0].mean(axis=2)
        assert lit[inside].max() < 1e-3
        np.testing.assert_allclose(lit[outside], 1, rtol=1e-3)
