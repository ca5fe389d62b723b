"""Are strong but valid models undone to every corner, and only those that are valid accepted?

Oracles: OpenCV's projection; closed forms of the radial model's fold and pole; and SciPy's root
finder on the radial profile.
"""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from simtip.camera import Camera, _solved, border, folds
from simtip.undistort import TOLERANCE_PX, checked_pixels, plan

SIZE = (2048, 1436)
MIDDLE = (1023.5, 717.5)
CORNER = float(np.hypot(1024, 718))

STRONG = {
    "barrel and pincushion": (1910, (-1.1904, 0.497, 0.0282, -0.0244, 1.3003)),
    "steep at the corner": (3000, (-1.5334, -4.7879, 0, 0, 23.52)),
    "pole beyond the corner": (1910, (0, 0, 0, 0, 0, -3, 0, 0)),
    "two terms": (1910, (-1.2, 0.9, 0, 0)),
    "wide and rational": (
        700,
        (-0.5541, -0.0531, -0.0025, -0.0024, -0.0281, -0.6296, -0.0687, -0.0226),
    ),
}
QUICK = ("barrel and pincushion", "wide and rational")


def camera(f: float, distortion: tuple[float, ...], middle: tuple[float, float] = MIDDLE) -> Camera:
    K = np.array([[f, 0, middle[0]], [0, f, middle[1]], [0, 0, 1]])
    return Camera(K, *SIZE, distortion)


def projected(which: Camera, xy: np.ndarray) -> np.ndarray:
    points = np.column_stack([xy, np.ones(len(xy))])
    pixels, _ = cv2.projectPoints(
        points, np.zeros(3), np.zeros(3), which.K, np.array(which.distortion)
    )
    return pixels.reshape(-1, 2)


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.slow] * (n not in QUICK)) for n in STRONG],
)
def test_every_pixel_has_the_ray_that_opencv_projects_onto_it(name):
    strong = camera(*STRONG[name])
    assert not folds(strong)
    pixels = checked_pixels(strong)
    rays = strong.normalise(pixels)
    assert np.isfinite(rays).all()
    np.testing.assert_allclose(projected(strong, rays), pixels, atol=1e-3)


@pytest.mark.parametrize("name", STRONG)
def test_the_renderer_will_undo_it(name):
    assert plan(camera(*STRONG[name])).error_px < TOLERANCE_PX / 2


@pytest.mark.parametrize("name", ["steep at the corner", "pole beyond the corner", "two terms"])
def test_the_ray_found_is_the_one_on_the_way_out_from_the_centre(name):
    """Along a radius the profile is one-dimensional, and its first root bracketed."""
    f, distortion = STRONG[name]
    k1, k2, _, _, k3, k4, k5, k6 = (*distortion, 0, 0, 0, 0)[:8]

    def profile(r: float) -> float:
        q = r * r
        return r * (1 + q * (k1 + q * (k2 + q * k3))) / (1 + q * (k4 + q * (k5 + q * k6)))

    wanted = CORNER / f
    r = np.linspace(0, 2, 20001)
    beyond = next(x for x in r if profile(x) >= wanted)
    expected = brentq(lambda x: profile(x) - wanted, 0, beyond)
    found = camera(f, distortion).normalise([-0.5, -0.5])
    assert np.linalg.norm(found) == pytest.approx(expected, rel=1e-6)


def test_a_pixel_that_no_ray_reaches_has_none():
    """r (1 + k1 r^2) ends at 2/3 of r = 1 / sqrt(-3 k1)."""
    k1 = -0.4
    far = 2 / 3 / np.sqrt(-3 * k1)
    rays = camera(1910, (k1, 0, 0, 0)).normalise(
        [[MIDDLE[0] + 1910 * far * part, MIDDLE[1]] for part in (0.9, 0.999, 1.001, 1.3)]
    )
    np.testing.assert_array_equal(np.isnan(rays).any(axis=1), [False, False, True, True])


def test_a_ray_from_beyond_the_fold_is_not_taken():
    """r (1 - 0.4 r^2) is 0.3 at 0.312 and at 1.402: the second one is upside down."""
    folding = camera(1910, (-0.4, 0, 0, 0))
    wanted = np.array([[MIDDLE[0] + 1910 * 0.3, MIDDLE[1]]] * 2)
    rays, kept = _solved(folding, np.array([[0.3, 0.0], [1.4, 0.0]]), wanted, 0.0)
    np.testing.assert_allclose(projected(folding, rays), wanted, atol=1e-6)
    np.testing.assert_allclose(rays[:, 0], [0.312168, 1.401771], atol=1e-6)
    assert kept.tolist() == [True, False]


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_fold_is_seen_at_the_very_corner(share):
    """The profile's greatest value 2/3 / sqrt(-3 k1), against the corner's radius."""
    f = 1910
    k1 = -(((2 / 3) / (CORNER / f * share)) ** 2) / 3
    assert folds(camera(f, (k1, 0, 0, 0))) is (share < 1)


@pytest.mark.parametrize("width", [1e-3, 1e-6])
def test_a_pole_is_seen_however_narrow(width):
    """1 + k4 q + k5 q^2 below 0 for q = 0.2 -+ width only, cancelled by the numerator elsewhere."""
    a, b = 0.2 - width, 0.2 + width
    k4, k5 = -(a + b) / (a * b), 1 / (a * b)
    near = 1 / 0.2
    assert folds(camera(1910, (-2 * near, near**2, 0, 0, 0, k4, k5, 0)))


def test_a_turning_point_is_seen_however_narrow():
    """A profile whose slope (1 - q / 0.2)^2 - d, q = r^2, is below 0 over a few pixels only."""
    d = 1e-5
    # The integral of 1 - d - 2 r^2 / 0.2 + r^4 / 0.04, over r.
    slope = np.array([1 - d, -2 / 0.2, 1 / 0.04])
    k = slope / [1, 3, 5]
    f = 1910 * (1 - d)  # takes the leading factor in
    assert folds(camera(f, (k[1] / k[0], k[2] / k[0], 0, 0)))
    assert not folds(camera(f, (0.99 * k[1] / k[0], k[2] / k[0], 0, 0)))


@pytest.mark.parametrize("tangential", [0.0, 1e-9])
def test_a_fold_is_seen_between_centre_and_border(tangential):
    """Slope (1 - q / 0.2)^2 - 0.02: back and forth within a few hundredths, but upright beyond."""
    slope = np.array([1 - 0.02, -2 / 0.2, 1 / 0.04])
    k1, k2 = (slope / [1, 3, 5] / slope[0])[1:]
    assert folds(camera(1910, (k1, k2, tangential, tangential)))


@pytest.mark.parametrize(
    "distortion",
    [
        (0, 0, 0.1, 0.1),
        (-1e3, 0, 0, 0),
        (1e6, -1e6, 1e6, -1e6, 1e6, 1e6, -1e6, 1e6),
        (1e300, -1e300, 0, 0),
    ],
)
def test_models_without_a_valid_region_are_known_in_silence(distortion):
    assert folds(camera(1910, distortion, (932.97, 657.90)))


def test_the_border_is_half_a_pixel_out_with_exact_corners():
    edge = border(camera(1910, ()), 100.0).tolist()
    for corner in ([-0.5, -0.5], [2047.5, -0.5], [-0.5, 1435.5], [2047.5, 1435.5]):
        assert corner in edge


@pytest.mark.slow
@settings(derandomize=True, deadline=None, max_examples=25)
@given(
    st.tuples(
        st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-0.03, 0.03), st.floats(-0.03, 0.03),
        st.floats(-2, 2), st.floats(-1.5, 1.5), st.floats(-1, 1), st.floats(-1, 1),
    ),
    st.sampled_from([900.0, 1910.0]),
)  # fmt: skip
def test_what_is_accepted_keeps_its_orientation_and_is_undone(distortion, f):
    lens = camera(f, distortion)
    if folds(lens):
        return
    pixels = border(lens, 40.0)
    rays = lens.normalise(pixels)
    np.testing.assert_allclose(projected(lens, rays), pixels, atol=1e-3)
    # Twice the area of a small triangle about the ray, in the image: positive all the way out.
    for part in (0.25, 0.5, 0.75, 1.0):
        a, b, c = (
            projected(lens, rays * part + np.array(d)) for d in ((0, 0), (1e-6, 0), (0, 1e-6))
        )
        assert (np.linalg.det(np.stack([b - a, c - a], axis=1)) > 0).all()
