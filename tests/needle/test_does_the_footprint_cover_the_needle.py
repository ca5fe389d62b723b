"""Does the footprint hold every pixel that the needle touches, and not many more?

Oracle: points strewn over the round needle's surface by its closed form, projected one by one.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from simtip.camera import Camera
from simtip.footprint import footprint, in_view
from simtip.geometry import Pose
from simtip.needle import Bevel, Cone, Needle

K = np.array([[477.0, 0, 233.2], [0, 478.0, 164.5], [0, 0, 1]])  # the paper's over 4
PINHOLE = Camera(K, 512, 359)
BARREL = Camera(K, 512, 359, (-0.2, 0.03, 1e-3, -5e-4))
PINCUSHION = Camera(K, 512, 359, (0.25, 0.1, 0.0, 0.0))
CONE = Needle(1.67, 150.0, Cone(5.0))
BEVEL = Needle(1.67, 150.0, Bevel(20.0))
HAIR = Needle(0.02, 150.0, Cone(100.0))  # a twentieth of a pixel wide, and less


def strewn(needle, count, seed=5):
    """Points on the surface, needle frame: along generators, denser at the tip, and on the cut."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 2 * np.pi, count)
    share = np.where(rng.random(count) < 0.5, rng.random(count), rng.random(count) ** 3)
    R, L = needle.radius_mm, needle.length_mm
    if isinstance(needle.tip, Cone):
        z = share * L
        r = R * np.minimum(z / needle.tip.length_mm, 1)
        return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)
    slope = 1 / math.tan(math.radians(needle.tip.angle_deg))
    x, y = R * np.cos(angle), R * np.sin(angle)
    side = np.stack([x, y, (R - x) * slope + share * (L - (R - x) * slope)], axis=1)
    inner = np.sqrt(rng.random(count))
    x, y = inner * x, inner * y
    return np.concatenate([side, np.stack([x, y, (R - x) * slope], axis=1)])


def touched(needle, T_cn, camera, count=8000):
    """The pixels that strewn points fall on."""
    points = T_cn.apply(strewn(needle, count))
    points = points[points[:, 2] > 1]
    pixels = camera.project(points)
    inside = camera.contains(pixels)
    points, pixels = points[inside], pixels[inside]
    if camera.distortion and len(pixels):
        # What the model folds back into the image is not really seen there.
        real = np.abs(camera.normalise(pixels) - points[:, :2] / points[:, 2:]).max(axis=1) < 1e-6
        pixels = pixels[real]
    u, v = np.rint(pixels).astype(int).T
    mask = np.zeros((camera.height, camera.width), bool)
    mask[v, u] = True
    return mask


apexes = st.tuples(st.floats(-60, 60), st.floats(-45, 45), st.floats(-20, 250))
axes = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1)


@settings(derandomize=True, deadline=None, max_examples=50)
@given(
    st.sampled_from([CONE, BEVEL, HAIR]),
    apexes,
    axes,
    st.floats(0, 360),
    st.sampled_from([PINHOLE, BARREL, PINCUSHION]),
)
def test_no_touched_pixel_is_missing(needle, apex, axis, roll, camera):
    T = needle.pose(apex, axis, roll)
    seen = touched(needle, T, camera)
    mask = footprint(needle, T, camera)
    assert mask.shape == (359, 512)
    assert not (seen & ~mask).any()
    assert in_view(needle, T, camera) or not seen.any()


@pytest.mark.slow
@pytest.mark.parametrize("camera", [PINHOLE, BARREL, PINCUSHION])
@pytest.mark.parametrize("needle", [CONE, BEVEL])
def test_the_margin_is_kept_and_little_is_added(needle, camera):
    T = needle.pose((10, 15, 170), (0.2, -1, 0.1), 40)
    seen = ndimage.binary_closing(
        np.pad(touched(needle, T, camera, 100000), 30, "edge"), iterations=2
    )
    seen = seen[30:-30, 30:-30]

    def widened(by):
        return ndimage.binary_dilation(seen, np.ones((2 * by + 1, 2 * by + 1)))

    for margin in (0, 2.5, 9):
        mask = footprint(needle, T, camera, margin)
        assert not (widened(math.floor(margin)) & ~mask).any()
        assert not (mask & ~widened(math.ceil(margin) + 4)).any()


def test_a_needle_just_outside_the_image_marks_its_margin_inside():
    """A vertical needle whose flank is 3 px beyond the right edge, u = 511.5."""
    x = (511.5 + 3 - K[0, 2]) / K[0, 0] * 170 + 0.835
    T = CONE.pose((x, 20, 170), (0, -1, 0))
    assert not in_view(CONE, T, PINHOLE)
    assert not footprint(CONE, T, PINHOLE, 0).any()
    assert footprint(CONE, T, PINHOLE, 4)[:, -1].any()


@pytest.mark.parametrize(
    ("apex", "axis"),
    [((0, 0, -10), (0, 0, -1)), ((500, 0, 170), (0, -1, 0)), ((0, 0, 1e9), (1, 0, 0))],
)
def test_a_needle_elsewhere_marks_nothing_it_should_not(apex, axis):
    mask = footprint(CONE, CONE.pose(apex, axis), PINHOLE, 2)
    assert mask.sum() <= 81  # a million km off, it is a point in the middle


@pytest.mark.parametrize("camera", [PINHOLE, BARREL])
def test_a_camera_inside_the_needle_sees_nothing_else(camera):
    needle = Needle(100.0, 150.0, Cone(5.0))
    mask = footprint(needle, needle.pose((0, 80, 10), (0, -1, 0)), camera)
    assert mask.all()


@pytest.mark.parametrize(("edge_px", "outward"), [(-0.5, -1), (511.5, 1)])
def test_exactly_what_is_in_the_image_is_in_view(edge_px, outward):
    """A pinhole: the needle's flank is moved across an upright edge by a thousandth of a px."""
    for beyond, expected in ((-1e-3, True), (1e-3, False)):
        edge = (edge_px + outward * beyond - K[0, 2]) / K[0, 0]  # x / z of the flank, seen aslant
        x = 170 * edge + outward * 0.835 * math.hypot(1, edge)
        T = CONE.pose((x, 20, 170), (0, -1, 0))
        # 128 sides fall short of the circle by 7e-4 px at most, which 1e-3 px exceeds.
        assert in_view(CONE, T, PINHOLE) is expected


@pytest.mark.parametrize(("edge_px", "outward"), [(-0.5, -1), (358.5, 1)])
def test_exactly_what_is_in_the_image_is_in_view_upright(edge_px, outward):
    """As before, with the apex alone crossing the upper or the lower edge."""
    for beyond, expected in ((-1e-6, True), (1e-6, False)):
        y = (edge_px + outward * beyond - K[1, 2]) / K[1, 1] * 170
        T = CONE.pose((20, y, 170), (0, outward, 0))
        assert in_view(CONE, T, PINHOLE) is expected


@pytest.mark.parametrize(
    ("camera", "u"), [(BARREL, -0.48), (BARREL, 0.55), (PINCUSHION, -0.43), (PINCUSHION, 0.5)]
)
def test_the_footprint_follows_a_needle_that_distortion_bends(camera, u):
    """Along the image's side a straight needle bends by more than 3 px, beyond the slack of 2."""
    T = HAIR.pose((170 * u, 55, 170), (0, -1, 0))
    bend = camera.project(T.apply([[0, 0, 0], [0, 0, 55], [0, 0, 110]]))[:, 0] @ [0.5, -1, 0.5]
    assert abs(bend) > 3
    seen = touched(HAIR, T, camera)
    assert seen.sum() > 250
    assert not (seen & ~footprint(HAIR, T, camera)).any()


@pytest.mark.parametrize("centre", [100.0, 100.25, 99.75])
def test_the_footprint_is_centred_on_the_needle(centre):
    """A hair upright on pixel column 100 is widened equally to both sides: no half pixel off."""
    T = HAIR.pose(((centre - K[0, 2]) / K[0, 0] * 170, 20, 170), (0, -1, 0))
    columns = np.flatnonzero(footprint(HAIR, T, PINHOLE)[100])
    assert (columns[0] + columns[-1]) / 2 == 100


def test_a_margin_is_no_negative_number():
    with pytest.raises(ValueError, match="margin_px"):
        footprint(CONE, Pose.identity(), PINHOLE, -1)
