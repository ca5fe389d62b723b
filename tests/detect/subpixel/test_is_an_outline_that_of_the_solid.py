"""Are the outlines those of the solids, seen from far away at the stated tilt?

Needle in half widths: x across, z along the axis as the image shows it, y away from the camera.
"""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from simtip.detect.subpixel.outline import FAMILIES

END, HALF = 14.0, 5.0


def cylinder(cot, azimuth, tilt, *, away):
    """Points (n, 2) x, z in the image of a cut cylinder's rim and of its far end.

    The axis rises by asin(tilt) from the image plane, away from the camera. `azimuth` is that of
    the apex from +x, on the far side unless `away`. Along the axis the cut reaches cot / cosine
    half widths times 1 - cos of the angle from the apex, so that the image shows it as cot.
    """
    cosine = np.sqrt(1 - tilt**2)
    axis = np.array([0.0, tilt, cosine])
    right = np.array([1.0, 0.0, 0.0])
    far = np.array([0.0, cosine, -tilt]) * (-1 if away else 1)
    angle = np.linspace(0, 2 * np.pi, 4000)
    round_it = np.cos(angle)[:, None] * right + np.sin(angle)[:, None] * far
    length = cot / cosine * (1 - np.cos(angle - azimuth))
    rim = round_it + length[:, None] * axis
    end = round_it + 2 * END / cosine * axis
    apex = np.cos(azimuth) * right + np.sin(azimuth) * far
    return rim[:, [0, 2]], end[:, [0, 2]], apex[[0, 2]]


def foremost(corners, x):
    """Least z at each x of a convex polygon's lower side."""
    order = np.argsort(corners[:, 0], kind="stable")
    return np.interp(x, corners[order, 0], corners[order, 1])


def hull_foremost(points, x):
    """Least z at each x of the convex hull of points."""
    hull = points[ConvexHull(points).vertices]
    a, b = hull, np.roll(hull, -1, axis=0)
    lower = b[:, 0] > a[:, 0]  # they run anticlockwise
    z = [
        np.where(
            (x >= p[0]) & (x <= q[0]), p[1] + (x - p[0]) / (q[0] - p[0]) * (q[1] - p[1]), np.inf
        )
        for p, q in zip(a[lower], b[lower], strict=True)
    ]
    return np.min(z, axis=0)


@pytest.mark.parametrize("away", [False, True])
@pytest.mark.parametrize(
    ("cot", "azimuth", "tilt"),
    [(2.7, 1.2, 0.0), (2.7, 2.0, 0.3), (1.0, 0.5, -0.2), (5.0, 1.5708, -0.5), (0.6, 2.9, 0.1)],
)
def test_a_bevel_is_a_cylinder_cut_by_a_plane(cot, azimuth, tilt, away):
    family = FAMILIES["bevel_away" if away else "bevel"]
    shape = np.array([cot, azimuth])
    corners = family.polygon(HALF, shape, 2 * END * HALF, tilt) / HALF
    rim, end, apex = cylinder(cot, azimuth, tilt, away=away)
    x = np.linspace(-0.98, 0.98, 99)
    expected = hull_foremost(np.concatenate([rim, end]), x)
    # Chords of an arc lie within it by at most a part in ARC_POINTS^2, more where it is long.
    assert foremost(corners[1:-1], x) == pytest.approx(expected, abs=0.02 + 0.006 * cot)
    assert np.array(family.apex(HALF, shape, tilt)) / HALF == pytest.approx(apex, abs=1e-12)
    assert corners[:, 0].min() == pytest.approx(-1)
    assert corners[:, 0].max() == pytest.approx(1)


@pytest.mark.parametrize(("cot", "azimuth", "tilt"), [(2.7, 1.2, 0.0), (2.7, 2.0, 0.3)])
def test_a_bevels_facet_is_its_rim(cot, azimuth, tilt):
    facet = FAMILIES["bevel"].facet(HALF, np.array([cot, azimuth]), tilt) / HALF
    rim, _, _ = cylinder(cot, azimuth, tilt, away=False)
    off = np.linalg.norm(facet[:, None] - rim, axis=2).min(axis=1)
    assert off.max() < 0.01
    depth = FAMILIES["bevel"].depth(HALF, np.array([cot, azimuth])) / HALF
    assert depth == pytest.approx(2 * cot)


@pytest.mark.parametrize(("length", "radius"), [(3.0, 0.0), (3.0, 0.4), (0.8, 0.7), (9.0, 0.05)])
def test_a_rounded_cone_is_a_ball_that_touches_both_flanks(length, radius):
    family = FAMILIES["round"]
    corners = family.polygon(HALF, np.array([length, radius]), END * HALF, 0.0) / HALF
    left, right = corners[1], corners[-2]
    assert (left[0], right[0]) == pytest.approx((-1, 1))
    # The flank's slope is the cone's.
    flank = right - corners[-3]
    assert flank[0] / flank[1] == pytest.approx(1 / length, rel=1e-9)
    # The foremost point is the apex, and the ball's centre one radius behind it.
    assert corners[1:-1, 1].min() == pytest.approx(0, abs=4e-3)
    assert family.apex(HALF, np.array([length, radius]), 0.0) == (0, 0)
    normal = np.array([flank[1], -flank[0]]) / np.hypot(*flank)
    assert (right - [0, radius]) @ normal == pytest.approx(radius, abs=1e-9)
    arc = corners[2:-2] - [0, radius]
    assert np.hypot(*arc.T) == pytest.approx(radius, abs=1e-9)
    assert right[1] * HALF == pytest.approx(family.depth(HALF, np.array([length, radius])))


def test_a_cone_is_a_rounded_one_without_the_ball():
    corners = FAMILIES["cone"].polygon(HALF, np.array([3.0]), END * HALF, 0.0) / HALF
    hull = corners[ConvexHull(corners).vertices]
    expected = [(-1, END), (-1, 3), (0, 0), (1, 3), (1, END)]
    near = [np.linalg.norm(hull - corner, axis=1).min() for corner in expected]
    assert max(near) < 1e-9
    assert FAMILIES["cone"].depth(HALF, np.array([3.0])) == pytest.approx(3 * HALF)


def test_a_wedge_runs_straight_from_its_point_to_both_shoulders():
    shape = np.array([0.3, 1.0, 4.0])
    corners = FAMILIES["wedge"].polygon(HALF, shape, END * HALF, 0.0) / HALF
    assert corners == pytest.approx(np.array([(-1, END), (-1, 1), (0.3, 0), (1, 4), (1, END)]))
    assert FAMILIES["wedge"].apex(HALF, shape, 0.0) == pytest.approx((0.3 * HALF, 0))
