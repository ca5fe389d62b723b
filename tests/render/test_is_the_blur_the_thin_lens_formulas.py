"""Is a point out of focus spread as far as the thin lens says?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip.geometry import Pose
from simtip.lens import ThinLens
from simtip.render import render_discs

FOCUS_MM = 170.0
APERTURE_MM = 6 / 1.4
DISC_PX = 0.5


def second_moments(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centroid (u, v) and central second moments (uu, vv) of a picture."""
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    total = image.sum()
    centre = np.array([(u * image).sum(), (v * image).sum()]) / total
    moments = [((u - centre[0]) ** 2 * image).sum(), ((v - centre[1]) ** 2 * image).sum()]
    return centre, np.array(moments) / total


SLOW = pytest.mark.slow


@pytest.mark.slow
@pytest.mark.parametrize("side", [pytest.param("left", marks=SLOW), "right"])
@pytest.mark.parametrize(
    "defocus_mm",
    [pytest.param(-30, marks=SLOW), -14, 14, *(pytest.param(z, marks=SLOW) for z in (30, 90))],
)
def test_the_second_moment_is_the_formulas(paper_rig, side, defocus_mm):
    camera, pose = (
        (paper_rig.left, Pose.identity()) if side == "left" else (paper_rig.right, paper_rig.T_lr)
    )
    camera = camera.cropped(1500, 300, 60, 60)
    lens = ThinLens(APERTURE_MM, FOCUS_MM)
    z = FOCUS_MM + defocus_mm
    pixel = np.array([29.3, 30.1])
    point = np.array([*camera.normalise(pixel), 1.0]) * z
    image = render_discs(
        camera, pose, pose.apply(point), DISC_PX * z / camera.K[0, 0], lens=lens, samples=16384
    )
    centre, found = second_moments(image)
    # A uniform disc of diameter c has the variance c^2 / 16 along each axis; a square pixel adds
    # 1/12. fx and fy differ a little, and so do the blurs.
    focal = np.array([camera.K[0, 0], camera.K[1, 1]])
    blur = np.array([lens.blur_px(f, z) for f in focal])
    disc = 2 * DISC_PX * focal / focal[0]
    expected = blur**2 / 16 + disc**2 / 16 + 1 / 12
    assert blur.min() > 3
    np.testing.assert_allclose(found, expected, rtol=0.02)
    np.testing.assert_allclose(centre, pixel, atol=0.1)


@pytest.mark.slow
def test_what_is_in_focus_is_as_sharp_as_through_a_pinhole(paper_rig):
    camera = paper_rig.left.cropped(1500, 300, 40, 40)
    point = np.array([*camera.normalise([19.4, 20.2]), 1.0]) * FOCUS_MM
    lens = ThinLens(APERTURE_MM, FOCUS_MM)
    radius = 3 * FOCUS_MM / camera.K[0, 0]
    sharp, through = (
        render_discs(camera, Pose.identity(), point, radius, lens=which, samples=4096)
        for which in (None, lens)
    )
    np.testing.assert_allclose(through, sharp, atol=0.03)


def test_a_closed_aperture_is_a_pinhole(paper_rig):
    camera = paper_rig.left.cropped(1500, 300, 40, 40)
    point = np.array([*camera.normalise([19.4, 20.2]), 1.0]) * 260
    radius = 3 * 260 / camera.K[0, 0]
    sharp, through = (
        render_discs(camera, Pose.identity(), point, radius, lens=which, samples=4096)
        for which in (None, ThinLens(1e-6, FOCUS_MM))
    )
    np.testing.assert_allclose(through, sharp, atol=0.03)
