"""Is a brushed needle's highlight as wide across, and as narrow along, as GGX says?

One point lamp, and nothing else: what each pixel then shows is the reflectance itself, here
evaluated anew in numpy on a cylinder in the needle's place.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles.metal import ggx, index
from regions import with_roi

from simtip.geometry import Pose, unit
from simtip.render import render_pair
from simtip.spec import SceneSpec

AXIS = unit([0.4, -1, 0.3])
TIP_MM = np.array([-10.0, 20.0, 170.0])
SPOT_MM = TIP_MM + 25 * AXIS
"""On the axis, where the highlight is put."""
RADIUS_MM, BALL_MM = 0.835, 40.0
WIDTH, HEIGHT = 40, 24
SUB = 6
"""Rays per pixel each way of the numpy picture."""
WAVELENGTH_NM = [600.0, 540.0, 460.0]


def lamp_place(eye: np.ndarray) -> np.ndarray:
    """From where light is mirrored into a camera by the side of the needle at SPOT."""
    to_eye = unit(eye - SPOT_MM)
    normal = unit(np.array([0.5, 0.1, -1]) - AXIS * (AXIS @ [0.5, 0.1, -1]))
    return SPOT_MM + 300 * (2 * (normal @ to_eye) * normal - to_eye)


def brushed(scene: SceneSpec, across: float, along: float | None, side: int) -> SceneSpec:
    rig = scene.rig.rig()
    corners = [np.rint(p - [WIDTH / 2, HEIGHT / 2]).astype(int) for p in rig.project(SPOT_MM)]
    rois = [[int(u), int(v), WIDTH, HEIGHT] for u, v in corners]
    data = with_roi(scene, *rois, samples=256, noise=None).model_dump(mode="json")
    data["needle"] |= {"axis": AXIS.tolist(), "tip_mm": TIP_MM.tolist()}
    data["needle"]["material"] |= {"roughness": across, "roughness_along": along}
    data["background"] |= {"centre_mm": [0, 0, 9000], "size_mm": [1, 1]}
    data["lamps"] = [{
        "name": "bulb", "kind": "point", "diameter_mm": BALL_MM,
        "centre_mm": lamp_place(np.zeros(3) if side == 0 else rig.T_lr.t).tolist(),
    }]  # fmt: skip
    return SceneSpec.model_validate(data)


def numpy_picture(spec: SceneSpec, side: int, alpha: tuple[float, float]) -> np.ndarray:
    """(H, W, 3) mean radiance of an endless cylinder; NaN where a ray misses it."""
    rig = spec.rig.rig()
    camera, T_wc = [(rig.left, Pose.identity()), (rig.right, rig.T_lr)][side]
    step = (np.arange(SUB) + 0.5) / SUB - 0.5
    u = (np.arange(WIDTH)[:, None] + step).ravel()
    v = (np.arange(HEIGHT)[:, None] + step).ravel()
    d = T_wc.rotate(camera.rays(np.stack(np.meshgrid(u, v), axis=-1)))
    off = T_wc.t - TIP_MM
    d_across, o_across = d - (d @ AXIS)[..., None] * AXIS, off - (off @ AXIS) * AXIS
    a, b = (d_across**2).sum(axis=-1), (d_across @ o_across)
    root = b**2 - a * (o_across @ o_across - RADIUS_MM**2)
    met = root > 0
    d = d[met]
    t = (-b[met] - np.sqrt(root[met])) / a[met]
    point = T_wc.t + t[..., None] * d
    from_axis = point - TIP_MM
    n = from_axis - (from_axis @ AXIS)[..., None] * AXIS
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    frame = np.stack([np.cross(AXIS, n), np.broadcast_to(AXIS, n.shape), n], axis=-2)
    to_lamp = np.array(spec.lamps[0].centre_mm) - point
    d2 = (to_lamp**2).sum(axis=-1)
    local = [np.einsum("...ij,...j->...i", frame, w)
             for w in (-d, to_lamp / np.sqrt(d2)[..., None])]  # fmt: skip
    light = np.full((*met.shape, 3), np.nan)
    light[met] = ggx(*local, alpha, index("titanium", WAVELENGTH_NM))
    light[met] *= (np.pi * BALL_MM**2 / 4 / d2)[..., None]
    return light.reshape(HEIGHT, SUB, WIDTH, SUB, 3).mean(axis=(1, 3))


@pytest.mark.parametrize(
    ("across", "along", "side"),
    [
        (0.3, 0.06, 1),
        pytest.param(0.06, 0.3, 0, marks=pytest.mark.slow),
        pytest.param(0.15, None, 1, marks=pytest.mark.slow),
    ],
    ids=["brushed", "turned", "even"],
)
def test_every_pixel_shows_the_lobe(scene, across, along, side):
    """The lamp's mirror image lies before the camera `side`; the other sees the lobe's flank."""
    spec = brushed(scene, across, along, side)
    assert tuple(spec.sensor.wavelength_nm) == tuple(WAVELENGTH_NM)
    for k, view in enumerate(render_pair(spec)):
        expected = numpy_picture(spec, k, (across, along or across))
        whole = view.coverage == 1
        assert whole.sum() > 300
        assert np.isfinite(expected[whole]).all()
        found = view.response[0][whole]
        scale = expected[whole].max()
        # The mesh is a prism of 1024 sides; its facets show where the lobe is narrow.
        error = np.abs(found - expected[whole])
        assert error.max() < 0.02 * scale
        np.testing.assert_allclose(found.sum(axis=0), expected[whole].sum(axis=0), rtol=5e-3)


@pytest.mark.slow
def test_as_rough_along_as_across_is_not_brushed(scene):
    even, both = (render_pair(brushed(scene, 0.2, along, 0)) for along in (None, 0.2))
    for one, other in zip(even, both, strict=True):
        # The lamp is one point, sampled with no noise but the pixel's.
        np.testing.assert_allclose(one.response[0], other.response[0], rtol=1e-3, atol=1e-6)
