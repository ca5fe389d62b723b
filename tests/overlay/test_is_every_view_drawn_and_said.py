from __future__ import annotations

import cv2
import numpy as np
import pytest

from simtip.overlay import draw_view, legend, side_by_side
from simtip.overlay.inset import Inset
from simtip.overlay.marks import LINE_COLOR

ALL = {
    "title": "left",
    "tip_true_px": (30.2, 20.6),
    "tip_detected_px": (30.0, 17.0),
    "epipolar_line": (0.1, 1.0, -20.0),
    "axis_px": (0.0, -1.0),
}
BIG = (700, 1000)


def plain(shape, value=150):
    return np.full((*shape, 3), value, np.uint8)


@pytest.fixture
def written(monkeypatch):
    """Collect every line of text that is drawn."""
    lines = []
    put = cv2.putText

    def record(image, text, *args):
        lines.append(text)
        return put(image, text, *args)

    monkeypatch.setattr(cv2, "putText", record)
    return lines


SIZES = [(1, 1), (1, 60), (60, 1), (3, 3), (40, 60), (140, 140), (30, 2000), (2000, 30)]


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("reason", [None, "no component is larger than 4500 px " * 4])
def test_any_size(shape, reason):
    view = draw_view(plain(shape), **ALL, reason=reason)
    assert view.shape == (*shape, 3)
    assert view.dtype == np.uint8
    bare = draw_view(plain(shape), title="", reason=reason)
    assert bare.shape == (*shape, 3)


def test_a_small_crop_still_shows_its_tips():
    view = draw_view(plain((40, 60)), **ALL).astype(int)
    difference = view[..., 2] - view[..., 0]
    assert difference.max() > 100
    assert difference.min() < -100


def test_nothing_given_is_nothing_drawn():
    image = np.random.default_rng(0).integers(0, 256, (*BIG, 3), dtype=np.uint8)
    np.testing.assert_array_equal(draw_view(image, title=""), image)


@pytest.mark.parametrize("shape", [(40, 60), BIG])
@pytest.mark.parametrize("gray", [True, False])
def test_the_input_stays_as_it_is(shape, gray):
    image = plain(shape)[..., 0] if gray else plain(shape)
    given = image.copy()
    view = draw_view(image, **ALL)
    np.testing.assert_array_equal(image, given)
    assert not np.shares_memory(view, image)
    image.setflags(write=False)
    np.testing.assert_array_equal(draw_view(image, **ALL), view)


def test_gray_is_drawn_as_the_same_colour_image():
    np.testing.assert_array_equal(
        draw_view(plain(BIG)[..., 0], **ALL), draw_view(plain(BIG), **ALL)
    )


@pytest.mark.parametrize("order", ["<u2", ">u2"])
def test_16_bit_is_scaled_to_8(order):
    deep = np.arange(65536, dtype=np.uint16).reshape(256, 256).astype(order)
    shown = draw_view(deep, title="")[..., 0]
    np.testing.assert_array_equal(shown, np.rint(deep / 257.0).astype(np.uint8))
    twelve = draw_view(deep, title="", white_dn=4095)[..., 0]
    expected = np.minimum(255, np.rint(deep * (255 / 4095)))
    np.testing.assert_array_equal(twelve, expected)


def test_16_bit_gets_the_same_marks():
    eight = plain(BIG)
    np.testing.assert_array_equal(
        draw_view(eight.astype(np.uint16) * 257, **ALL), draw_view(eight, **ALL)
    )


@pytest.mark.parametrize("tip", [(-5000.0, 20.0), (500.0, 1e12), (1000.0, 300.0), (3.0, -0.6)])
def test_a_tip_outside_the_image_is_said(written, tip):
    view = draw_view(plain(BIG), title="left", tip_true_px=tip)
    assert view.shape == (*BIG, 3)
    assert "true tip (outside the image)" in written


def test_a_line_outside_the_image_is_said(written):
    draw_view(plain(BIG), title="left", epipolar_line=(0, 1, 20))
    draw_view(plain(BIG), title="left", epipolar_line=(0, 1, -20))
    assert [text for text in written if "epipolar" in text] == [
        "epipolar line (outside the image)",
        "epipolar line",
    ]


def test_the_legend_names_what_is_drawn_and_no_more(written):
    draw_view(plain(BIG), title="left view", tip_detected_px=(500, 300))
    assert set(written) == {"left view", "detected tip", "inset: 4 times as large"}


@pytest.mark.parametrize(
    ("axis", "said"),
    [
        ((0.0, -1.0), "error: along +6.90 px, across +0.10 px"),
        ((0.0, 1.0), "error: along -6.90 px, across -0.10 px"),
        # axis to the right: turned clockwise as seen it points down, +v
        ((2.0, 0.0), "error: along +0.10 px, across -6.90 px"),
        (None, "error: |d| = 6.90 px"),
    ],
)
def test_the_error_is_detected_minus_true(written, axis, said):
    draw_view(
        plain(BIG),
        title="",
        tip_true_px=(500, 300),
        tip_detected_px=(500.1, 293.1),
        axis_px=axis,
    )
    assert said in " ".join(written)


def test_an_error_is_never_minus_zero(written):
    draw_view(
        plain(BIG),
        title="",
        tip_true_px=(500, 300),
        tip_detected_px=(499.9996, 300.26),
        axis_px=(1, 0),
    )
    assert "error: along +0.00 px, across +0.26 px" in " ".join(written)


def test_a_reason_is_wrapped_and_complete(written):
    reason = "no component of needle polarity is larger than 4500 px; the largest has 3120 px"
    draw_view(plain(BIG), title="", tip_true_px=(500, 300), reason=reason)
    lines = [text for text in written if text != "true tip" and "inset" not in text]
    assert len(lines) > 1
    assert " ".join(lines) == f"No tip detected: {reason}"
    widest = max(cv2.getTextSize(t, cv2.FONT_HERSHEY_SIMPLEX, 0.52 * 1.25, 1)[0][0] for t in lines)
    assert widest < 0.5 * BIG[1]


def test_only_ascii_is_written(written):
    draw_view(plain(BIG), title="Nadel \N{MICRO SIGN}m", reason="zu\nklein \N{DEGREE SIGN}")
    assert written == ["Nadel ?m", "No tip detected: zu klein ?"]


TOWARDS_HUB = [(0, -1), (0, 1), (-1, 0), (1, 0), (0.6, -0.8), (-0.6, 0.8), (0.8, 0.6), (-0.8, -0.6)]


@pytest.mark.parametrize("axis", TOWARDS_HUB)
@pytest.mark.parametrize("tip", [(500, 350), (300, 200), (800, 550)])
@pytest.mark.parametrize(("dn", "axis_known"), [(20, True), (20, False), (120, True)])
def test_neither_tip_nor_needle_is_hidden(axis, tip, dn, axis_known):
    """A dark needle is found in the image, a pale one by its axis.

    It must be seen from 80 px behind its tip (the marks are there) to the border.
    """
    image = plain(BIG)
    along = np.arange(0, 1500)[:, None] * np.array(axis) + tip
    ends = [tuple(round(x) for x in along[i]) for i in (0, -1)]
    cv2.line(image, *ends, (dn, dn, dn), 9)
    view = draw_view(image, title="left", tip_true_px=tip, axis_px=axis if axis_known else None)
    seen = np.rint(along[80:]).astype(int)
    seen = seen[(seen >= 0).all(axis=1) & (seen < (BIG[1], BIG[0])).all(axis=1)]
    assert len(seen) > 50
    np.testing.assert_array_equal(view[seen[:, 1], seen[:, 0]], dn)
    around = np.s_[tip[1] - 3 : tip[1] + 4, tip[0] - 3 : tip[0] + 4]
    np.testing.assert_array_equal(view[around], image[around])


def test_the_legend_leaves_the_epipolar_line_free_if_it_can():
    view = draw_view(plain(BIG), title="left view", epipolar_line=(1, 1, -150))
    np.testing.assert_array_equal(view[75, 75], LINE_COLOR)
    np.testing.assert_array_equal(view[20, 130], LINE_COLOR)


@pytest.mark.parametrize("tip", [(200, 150), (60, 40), (330, 250), (60, 250), (330, 40)])
@pytest.mark.parametrize("words", [0, 8, 30])
def test_inset_and_legend_keep_apart(monkeypatch, tip, words):
    boxes = {}
    draw_inset, draw_panel = Inset.draw, legend._Panel.draw

    def inset(self, *args):
        boxes["inset"] = self.box
        draw_inset(self, *args)

    def panel(self, view, box):
        boxes["panel"] = box
        draw_panel(self, view, box)

    monkeypatch.setattr(Inset, "draw", inset)
    monkeypatch.setattr(legend._Panel, "draw", panel)
    title = "a longer title of a view " + "of words " * words
    draw_view(plain((300, 400)), title=title, tip_true_px=tip, tip_detected_px=tip)
    a, b = boxes["inset"], boxes["panel"]
    for box in (a, b):
        assert not (box.u0 <= tip[0] < box.u1 and box.v0 <= tip[1] < box.v1)
    assert a.u1 < b.u0 or b.u1 < a.u0 or a.v1 < b.v0 or b.v1 < a.v0


@pytest.mark.parametrize(
    "wrong",
    [
        {"tip_true_px": (np.nan, 3)},
        {"tip_detected_px": (1, 2, 3)},
        {"epipolar_line": (0, 0, 1)},
        {"epipolar_line": (1, np.inf, 1)},
        {"axis_px": (0, 0)},
        {"white_dn": 0},
        {"white_dn": np.nan},
    ],
)
def test_numbers_that_mean_nothing_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        draw_view(plain((40, 60)), title="", **wrong)


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((0, 5), np.uint8),
        np.zeros((4, 5, 4), np.uint8),
        np.zeros((4, 5)),
        np.zeros(4, "u1"),
    ],
)
def test_arrays_that_are_no_image_are_refused(image):
    with pytest.raises(ValueError, match="an image is"):
        draw_view(image, title="")


def test_a_pair_keeps_both_pictures_and_parts_them():
    left, right = plain((30, 400), 10), plain((50, 300), 20)
    both = side_by_side(left, right)
    gap = both.shape[1] - 700
    assert 1 <= gap <= 10
    np.testing.assert_array_equal(both[:30, :400], left)
    np.testing.assert_array_equal(both[:, 400 + gap :], right)
    assert (both[:, 400 : 400 + gap] == 255).all()
    assert (both[30:, :400] == 255).all()


def test_the_legend_hides_no_tip_that_the_inset_leaves_out():
    true, detected = (700.0, 500.0), (90.0, 60.0)
    view = draw_view(plain(BIG), title="left", tip_true_px=true, tip_detected_px=detected)
    around = view[54:67, 84:97].astype(int)
    assert (around[..., 0] - around[..., 2]).max() > 100  # the dot, vermilion
    np.testing.assert_array_equal(view[60, 96], 150)  # between dot and ring: the image
