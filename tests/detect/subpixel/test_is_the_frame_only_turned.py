"""Are points, vectors and pixels turned alike, and turned back to where they were?"""

import hypothesis.strategies as st
import numpy as np
from hypothesis import given, settings

from simtip.detect.subpixel.frame import Frame

directions = st.floats(-np.pi, np.pi).map(lambda a: np.array([np.cos(a), np.sin(a)]))
shapes = st.tuples(st.integers(1, 12), st.integers(1, 12))

places = st.integers(-4000, 4000).map(lambda n: n / 64)  # exact when added to whole numbers


@settings(max_examples=60)
@given(directions, shapes)
def test_the_view_shows_at_a_turned_point_the_images_pixel(direction, shape):
    image = np.arange(np.prod(shape)).reshape(shape)
    frame = Frame.down(direction, shape)
    view = frame.view(image)
    v, u = np.indices(shape)
    turned = frame.points(np.stack([u, v], axis=-1).astype(float)).astype(int)
    assert view.shape[0] == frame.height
    assert np.array_equal(view[turned[..., 1], turned[..., 0]], image)
    assert np.shares_memory(view, image)


@settings(max_examples=60)
@given(directions, shapes, places, places)
def test_turned_back_everything_is_where_it_was(direction, shape, u, v):
    frame = Frame.down(direction, shape)
    p = np.array([[u, v], [v, u - 1]])
    assert np.array_equal(frame.points_back(frame.points(p)), p)
    assert np.array_equal(frame.points(frame.points_back(p)), p)
    assert np.array_equal(frame.vectors_back(frame.vectors(p)), p)
    # A vector is what leads from one point to another.
    led = frame.points(p + direction) - frame.points(p)
    assert np.allclose(led, frame.vectors(direction), atol=1e-9)


@settings(max_examples=60)
@given(directions, shapes)
def test_the_direction_points_down_within_45_degrees(direction, shape):
    u, v = Frame.down(direction, shape).vectors(direction)
    assert v >= abs(u)
