"""Is the side of a needle that mirrors a lamp, beyond full scale, part of it?"""

import numpy as np
import pytest
from drawn_needles import Drawn, bevel, off, photograph

from simtip.detect.subpixel import SubpixelParameters, detect
from simtip.detect.subpixel.first_look import first_shaft
from simtip.detect.subpixel.lit_side import with_lit_side
from simtip.detect.subpixel.saturated import without_saturated
from simtip.detect.subpixel.shaft_pixels import edges_px
from simtip.detect.subpixel.trace import trace

PLACED = {"ground_dn": 170.0, "degrees": 0.0, "shape": (420, 220), "tip_px": (110.3, 380.6)}
LIT = Drawn(
    ground_dn=170,
    degrees=3.0,
    sigma_px=0.9,
    shape=(420, 220),
    tip_px=(110.3, 380.6),
    streak=(-0.5, 0.4, 3.0),
)
UPRIGHT = LIT.but(degrees=0.0, sigma_px=0.7)
ROWS = slice(0, 300)


def traced(drawn, picture, width_px, centre):
    """Trace a band of an upright needle, `centre` from its axis."""
    return trace(picture, (drawn.tip_px[0] + centre, 0.0), width_px)


INTO_THE_POINT = "blurred, a streak that goes into the point reads as a rounded end: 0.5 to 4 px"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("x", "sigma_px"),
    [
        (-0.65, 0.6),
        (-0.45, 0.6),
        (0.35, 0.6),
        (-0.55, 0.9),
        (-0.35, 0.9),
        (0.65, 0.9),
        (-0.45, 1.3),
        (0.55, 1.3),
        pytest.param(0.45, 1.3, marks=pytest.mark.xfail(reason=INTO_THE_POINT, strict=True)),
    ],
)
def test_the_tip_is_where_it_is(x, sigma_px):
    """Taken for what it shows, the streak moved it by 0.3 to 1.5 px."""
    drawn = LIT.but(streak=(x, 0.4, 3.0), sigma_px=sigma_px)
    straight = SubpixelParameters(focal_px=2000.0, centre_px=drawn.tip_px)
    pictures = [photograph(drawn.light(), k) for k in range(3)]
    errors = np.array([off(detect(picture, straight), drawn) for picture in pictures])
    assert np.abs(errors[:, 0]).max() < 0.2
    assert np.abs(errors[:, 1]).max() < 0.05


def test_a_dark_band_is_widened_by_the_lit_strip_beside_it():
    picture = photograph(UPRIGHT.light(), 1)
    line, width_px = with_lit_side(picture, traced(UPRIGHT, picture, 11.0, 4.5))
    assert width_px == pytest.approx(UPRIGHT.width_px, abs=1.5)
    assert line[0] == pytest.approx(UPRIGHT.tip_px[0], abs=1)


def test_a_bright_thing_beside_a_needle_is_no_part_of_it():
    drawn = UPRIGHT.but(streak=None)
    picture = photograph(drawn.light(), 1)
    for gap in (6, 12):
        left = int(drawn.tip_px[0] + drawn.width_px / 2 + gap)
        beside = picture.copy()
        beside[:, left : left + 12] = 255
        assert with_lit_side(beside, traced(drawn, beside, drawn.width_px, 0.0)) is None


@pytest.mark.parametrize("gap", [14, 20, 28])
@pytest.mark.parametrize("rows", [420, 200])
def test_beside_something_dark_the_ground_is_not_lit(gap, rows):
    """Taken for a lit side, it moved the tip by 8 px."""
    drawn = LIT.but(streak=None)
    light = drawn.light()
    light[:rows, : int(drawn.tip_px[0] - drawn.width_px / 2 - gap) - 20] = 40
    found = detect(photograph(light, 1), SubpixelParameters(focal_px=2000.0))
    assert np.abs(off(found, drawn)).max() < 0.1


@pytest.mark.parametrize("higher", [0, 60])
def test_a_second_needle_beside_is_another(higher):
    drawn = LIT.but(streak=None)
    other = drawn.but(tip_px=(drawn.tip_px[0] + 40, drawn.tip_px[1] - higher))
    both = np.minimum(drawn.light(), other.light())
    found = detect(photograph(both, 1), SubpixelParameters(focal_px=2000.0))
    assert np.abs(off(found, drawn)).max() < 0.1


@pytest.mark.parametrize("width_px", [20.0, 40.0])
def test_a_pale_needle_before_a_gradient_is_not_widened(width_px):
    drawn = UPRIGHT.but(streak=None, width_px=width_px, contrast=0.4, degrees=3.0)
    light = drawn.light() + 0.6 * (np.arange(drawn.shape[1]) - drawn.tip_px[0])
    found = detect(photograph(light, 1), SubpixelParameters(focal_px=2000.0))
    assert np.abs(off(found, drawn)).max() < 0.2


def test_a_plain_needle_is_not_widened():
    drawn = UPRIGHT.but(streak=None)
    picture = photograph(drawn.light(), 1)
    assert with_lit_side(picture, traced(drawn, picture, drawn.width_px, 0.0)) is None


def told(drawn, end):
    """Give picture and what counts of it, the shaft ending at a row."""
    picture = photograph(drawn.light(), 1)
    found = traced(drawn, picture, drawn.width_px, 0.0)
    return picture, without_saturated(picture.astype(np.float32), found, end)


def test_a_streak_at_full_scale_is_left_out_with_its_neighbours():
    picture, kept = told(UPRIGHT, 320)
    middle = UPRIGHT.tip_px[0] - 0.5 * UPRIGHT.width_px / 2
    left_out = np.isnan(kept)
    assert left_out[ROWS, round(middle) - 2 : round(middle) + 3].all()
    assert not left_out[ROWS, : round(middle) - 5].any()
    assert not left_out[ROWS, round(middle) + 6 :].any()
    assert (kept[~left_out] == picture[~left_out]).all()


def test_a_streak_is_left_out_where_it_is_just_below_full_scale():
    light = UPRIGHT.light()
    light[200:260] *= 0.42
    picture = photograph(light, 1)
    assert picture[200:260].max() < 250
    found = traced(UPRIGHT, picture, UPRIGHT.width_px, 0.0)
    kept = without_saturated(picture.astype(np.float32), found, 320)
    middle = round(UPRIGHT.tip_px[0] - 0.5 * UPRIGHT.width_px / 2)
    assert np.isnan(kept[200:260, middle]).all()


def test_a_facet_at_full_scale_stays():
    """It shows the tip's outline."""
    drawn = bevel(2.5, np.pi / 2, facet_level=2.0, **PLACED)
    picture, kept = told(drawn, 320)
    assert (picture == 255).sum() > 100
    assert not np.isnan(kept[325:]).any()


@pytest.mark.slow
@pytest.mark.parametrize("top", [70, 100])
def test_of_a_streak_before_a_ground_that_is_full_at_the_hub(top):
    """There all that is at one side may be full."""
    drawn = LIT.but(streak=(-0.5, 0.4, 3.0))
    v = np.arange(drawn.shape[0])[:, None]
    light = drawn.light() + 150 / (1 + np.exp((v - top) / 6))
    found = detect(photograph(light, 1), SubpixelParameters(focal_px=2000.0))
    assert np.abs(off(found, drawn)).max() < 0.1


@pytest.mark.slow
def test_a_spot_at_full_scale_behind_the_tip_is_no_streak():
    drawn = LIT.but(streak=None)
    v, u = np.mgrid[: drawn.shape[0], : drawn.shape[1]]
    spot = 200 * np.exp(-0.5 * ((v - 330) ** 2 + (u - drawn.tip_px[0]) ** 2) / 40**2)
    found = detect(photograph(drawn.light() + spot, 1), SubpixelParameters(focal_px=2000.0))
    along, across = off(found, drawn)
    claimed = np.sqrt(drawn.axis @ found.covariance_px @ drawn.axis)
    assert abs(along) < max(0.3, 3 * claimed)
    assert abs(across) < 0.1


def test_a_side_that_is_full_altogether_has_no_edge():
    """Of the pictures above some had rows like that, and no pixel to look at."""
    drawn = UPRIGHT.but(streak=None)
    picture = photograph(drawn.light(), 1).astype(np.float32)
    picture[:, : round(drawn.tip_px[0])] = np.nan
    shaft = first_shaft(traced(drawn, photograph(drawn.light(), 1), drawn.width_px, 0.0))
    left, right = edges_px(picture, np.arange(96), shaft)
    assert np.isfinite(left)
    assert right == pytest.approx(drawn.width_px / 2, abs=0.5)


def test_before_an_overexposed_background_nothing_is_left_out():
    _, kept = told(UPRIGHT.but(ground_dn=240), 320)
    assert not np.isnan(kept).any()
