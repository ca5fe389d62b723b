"""Does each step of the paper's extraction do exactly what its text says?"""

from fractions import Fraction

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy import ndimage

from simtip.detect import lin2020_steps as steps
from simtip.detect.components import needle_axis
from simtip.detect.gray import to_gray
from simtip.errors import InputError

LIKE_PROPERTY = settings(derandomize=True, deadline=None, max_examples=50)


def small_images(shape):
    return hnp.arrays(np.uint8, shape)


def white(height, width):
    return np.full((height, width), 255, np.uint8)


def drawn(rows):
    """Draw a two-level image: # is needle."""
    return np.array([[0 if c == "#" else 255 for c in row] for row in rows], np.uint8)


# --- gray -----------------------------------------------------------------------------------


@LIKE_PROPERTY
@given(small_images(st.tuples(st.integers(1, 6), st.integers(1, 6), st.just(3))))
def test_gray_is_the_weighted_average_rounded_with_halves_up(image):
    exact = (image.astype(int) @ [299, 587, 114] + 500) // 1000
    assert np.array_equal(to_gray(image), exact)


def test_gray_rounds_an_exact_half_up():
    r, g, b = np.meshgrid(np.arange(256), np.arange(0, 256, 15), np.arange(256), indexing="ij")
    sums = 299 * r + 587 * g + 114 * b
    half = sums % 1000 == 500
    image = np.stack([r[half], g[half], b[half]], axis=-1)[None].astype(np.uint8)
    assert half.sum() > 1000
    assert np.array_equal(to_gray(image)[0], sums[half] // 1000 + 1)


def test_gray_takes_the_channels_as_rgb():
    pure = np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255]]], np.uint8)
    assert to_gray(pure).tolist() == [[76, 150, 29]]
    assert to_gray(pure, weights=(0.0, 0.0, 1.0)).tolist() == [[0, 0, 255]]


def test_gray_agrees_with_opencv_to_its_fixed_point_rounding():
    image = np.random.default_rng(1).integers(0, 256, (40, 50, 3), dtype=np.uint8)
    difference = to_gray(image).astype(int) - cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    assert np.abs(difference).max() <= 1
    assert (difference != 0).mean() < 0.01


@pytest.mark.parametrize(("full_scale", "white_dn"), [(None, 65535), (1023, 1023), (4095, 4095)])
def test_sixteen_bit_gray_is_rounded_to_eight_bits_once(full_scale, white_dn):
    values = np.arange(white_dn + 1, dtype=np.uint16)[None]
    exact = (2 * 255 * values.astype(int) + white_dn) // (2 * white_dn)
    assert np.array_equal(to_gray(values, full_scale=full_scale), exact)


def test_every_eight_bit_value_survives_sixteen_bits():
    values = np.arange(256, dtype=np.uint8)[None]
    assert np.array_equal(to_gray(values.astype(np.uint16) * 257), values)


@LIKE_PROPERTY
@given(hnp.arrays(np.uint16, (3, 4, 3), elements=st.integers(0, 1023)), st.booleans())
def test_sixteen_bit_colour_is_averaged_before_it_is_rounded(image, ten_bit):
    white_dn = 1023 if ten_bit else 65535
    exact = [
        int(
            sum(Fraction(int(c) * w, 1000) for c, w in zip(px, (299, 587, 114), strict=True))
            * Fraction(255, white_dn)
            + Fraction(1, 2)
        )
        for px in image.reshape(-1, 3)
    ]
    gray = to_gray(image, full_scale=white_dn if ten_bit else None)
    assert gray.ravel().tolist() == exact
    # channels rounded first would give 0, 0, 1 and so 0; their average is 129.4 / 257
    assert to_gray(np.array([[[128, 128, 140]]], np.uint16)).item() == 1


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((4, 4), np.float32),
        np.zeros((4, 4), np.int16),
        np.zeros((4, 4), bool),
        np.zeros((4, 4, 4), np.uint8),
        np.zeros((4, 4, 1), np.uint8),
        np.zeros((4,), np.uint8),
        np.zeros((0, 4), np.uint8),
        np.zeros((4, 0, 3), np.uint8),
        np.uint8(3).reshape(()),
        [[1, 2], [3, 4]],
    ],
)
def test_an_array_that_is_no_image_is_an_input_error(image):
    with pytest.raises(InputError):
        to_gray(image)


def test_full_scale_is_refused_where_it_cannot_be_right():
    with pytest.raises(InputError, match=r"detect\.full_scale.*8 bits"):
        to_gray(np.zeros((2, 2), np.uint8), full_scale=4095)
    with pytest.raises(InputError, match=r"detect\.full_scale.*4096 is above 4095"):
        to_gray(np.full((2, 2), 4096, np.uint16), full_scale=4095)


# --- median ---------------------------------------------------------------------------------


@LIKE_PROPERTY
@given(
    small_images(st.tuples(st.integers(1, 12), st.integers(1, 12))),
    st.sampled_from([1, 3, 5, 7]),
)
def test_median_is_that_of_the_window_with_the_border_repeated(image, window):
    expected = ndimage.median_filter(image, size=window, mode="nearest")
    assert np.array_equal(steps.median_filter(image, window), expected)


def test_median_of_five_takes_twelve_outliers_but_not_thirteen():
    image = white(9, 9)
    image[2:5, 2:6] = 0
    assert steps.median_filter(image, 5)[4, 4] == 255
    image[5, 2] = 0
    assert steps.median_filter(image, 5)[4, 4] == 0


@pytest.mark.parametrize("window", [0, 2, -3])
def test_an_even_window_is_an_input_error(window):
    with pytest.raises(InputError, match=r"detect\.median_window"):
        steps.median_filter(white(4, 4), window)


# --- threshold ------------------------------------------------------------------------------


def test_a_pixel_at_the_threshold_is_background():
    assert steps.binarise(np.array([[104, 105, 106]], np.uint8)).tolist() == [[0, 255, 255]]
    ramp = np.arange(256, dtype=np.uint8)[None]
    for threshold in (1, 128, 255):
        assert (steps.binarise(ramp, threshold) == 0).sum() == threshold


# --- components -----------------------------------------------------------------------------


def test_a_component_of_exactly_the_area_stays_and_one_less_goes():
    image = white(200, 200)
    image[10:70, 10:85] = 0  # 60 x 75 = 4500
    assert np.array_equal(steps.remove_small_components(image), image)
    image[10, 10] = 255
    assert steps.remove_small_components(image).min() == 255


def test_small_dark_components_go_and_bright_holes_stay_unless_asked():
    image = drawn(
        [
            "........",
            ".#####..",
            ".##.##..",
            ".#####.#",
            "........",
        ]
    )
    dark_gone, hole_filled = image.copy(), image.copy()
    dark_gone[3, 7] = 255
    hole_filled[2, 3] = 0
    both = np.where(hole_filled == 0, hole_filled, dark_gone)
    both[3, 7] = 255
    assert np.array_equal(steps.remove_small_components(image, 3), dark_gone)
    assert np.array_equal(steps.remove_small_components(image, 3, 8, "bright"), hole_filled)
    assert np.array_equal(steps.remove_small_components(image, 3, 8, "both"), both)


def test_connectivity_decides_about_diagonal_neighbours():
    image = drawn(["#.....", ".#....", "..#..."])
    assert np.array_equal(steps.remove_small_components(image, 3, 8), image)
    assert steps.remove_small_components(image, 3, 4).min() == 255


@LIKE_PROPERTY
@given(hnp.arrays(bool, (9, 11)), st.integers(1, 8), st.sampled_from([4, 8]))
def test_removal_agrees_with_scipy(dark, area, connectivity):
    structure = ndimage.generate_binary_structure(2, 1 if connectivity == 4 else 2)
    labels, count = ndimage.label(dark, structure)
    sizes = ndimage.sum_labels(dark, labels, range(count + 1))
    kept = dark & (sizes >= area)[labels]
    image = np.where(dark, 0, 255).astype(np.uint8)
    result = steps.remove_small_components(image, area, connectivity)
    assert np.array_equal(result == 0, kept)
    assert set(np.unique(result)) <= {0, 255}


def test_only_the_largest_is_kept_on_request():
    image = drawn(["##..###", "##..###", ".......", "#######"])
    kept = steps.keep_largest_component(image)
    assert np.array_equal(kept == 0, [[False] * 7, [False] * 7, [False] * 7, [True] * 7])
    assert np.array_equal(steps.keep_largest_component(white(3, 3)), white(3, 3))


# --- edges and the lowest of them -----------------------------------------------------------


def test_edges_of_a_hanging_bar_outline_it_and_end_on_its_last_row():
    image = white(40, 40)
    image[0:20, 15:20] = 0
    edge = steps.edges(image)
    assert set(np.unique(edge)) == {0, 255}
    assert np.flatnonzero(edge.any(axis=1)).tolist() == list(range(20))
    assert np.flatnonzero(edge[19]).tolist() == [15, 16, 17, 18, 19]


def test_lowest_edge_pixel_is_the_largest_v_and_a_point_is_u_then_v():
    edge = np.zeros((10, 20), np.uint8)
    edge[2, 3] = edge[7, 12] = edge[6, 1] = 255
    assert steps.lowest_edge_pixel(edge).tolist() == [12, 7]


@pytest.mark.parametrize(
    ("columns", "ties", "u"),
    [
        ([4, 5, 6, 7], "mean", 5.5),
        ([4, 5, 6, 7], "left", 4),
        ([4, 5, 6, 7], "right", 7),
        ([2, 10, 11, 12], "mean", 11),
        ([2, 10, 11, 12], "left", 2),
        ([2, 3, 11, 12], "mean", 2.5),
        ([0], "mean", 0),
        ([19], "mean", 19),
    ],
)
def test_ties_on_the_lowest_row_are_settled_as_asked(columns, ties, u):
    edge = np.zeros((10, 20), np.uint8)
    edge[3] = 255
    edge[8, columns] = 255
    assert steps.lowest_edge_pixel(edge, ties).tolist() == [u, 8]


def test_no_edge_has_no_lowest_pixel():
    assert steps.lowest_edge_pixel(np.zeros((5, 5), np.uint8)) is None


# --- axis -----------------------------------------------------------------------------------


@pytest.mark.parametrize("degrees", [-120, -90, -60, -20, 0, 10])
def test_axis_points_from_the_tip_along_the_needle(degrees):
    direction = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    across = np.array([-direction[1], direction[0]])
    tip = np.array([200.0, 200.0])
    outline = [(0, 0), (20, 5), (150, 5), (150, -5), (20, -5)]
    corners = np.array([tip + along * direction + aside * across for along, aside in outline])
    image = white(400, 400)
    cv2.fillPoly(image, [np.round(corners).astype(np.int32)], 0)
    axis = needle_axis(image, tip)
    assert axis @ direction > np.cos(np.radians(0.5))
    assert np.linalg.norm(axis) == pytest.approx(1)


def test_axis_is_that_of_the_component_at_the_tip_alone():
    image = white(200, 200)
    image[20:150, 50:58] = 0
    image[170:180, 10:190] = 0
    assert needle_axis(image, np.array([53.5, 149])) == pytest.approx([0, -1], abs=1e-12)
    assert abs(needle_axis(image, np.array([100, 179]))[0]) == pytest.approx(1)


def test_a_blob_has_no_axis():
    image = white(60, 60)
    image[10:40, 10:40] = 0
    assert needle_axis(image, np.array([25.0, 39.0])) is None
    assert needle_axis(image, np.array([55.0, 55.0])) is None
