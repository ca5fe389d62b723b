"""Bars lead from the remainder to the total, whatever the signs, the sizes and the names."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.colors import to_hex

from simtip.report.style import BLUE, ORANGE, png
from simtip.report.waterfall import Budget, waterfall_figure

LONG = (
    "flicker of the lamps and an exposure that is no whole number of half periods of the mains, "
    "in both images"
)


def budget(shares=(0.01, 0.05, -0.02, 0.0004), total=0.06, names=None, **others):
    shares = np.array(shares, float)
    return Budget(
        title=others.pop("title", "position of the tip"),
        names=names or [f"cause {k}" for k in range(len(shares))],
        shares=shares,
        intervals=np.column_stack([shares - 0.002, shares + 0.003]),
        total=total,
        total_interval=(0.9 * total, 1.2 * total),
        **others,
    )


def rows(axes):
    """Name, start, end and colour of each bar from the top down."""
    names = [label.get_text() for label in axes.get_yticklabels()]
    bars = sorted(axes.patches, key=lambda bar: bar.get_y())
    at = [bar.get_y() + bar.get_height() / 2 for bar in bars]
    np.testing.assert_allclose(at, sorted(axes.get_yticks()))
    named = dict(zip(axes.get_yticks(), names, strict=True))
    found = []
    for middle, bar in zip(at, bars, strict=True):
        name = named[min(named, key=lambda y, middle=middle: abs(y - middle))]
        start = bar.get_x()
        found.append((name, start, start + bar.get_width(), to_hex(bar.get_facecolor())))
    return found


def whiskers(axes):
    """Both ends of each, from the top down."""
    found = [one for one in axes.lines if one.get_marker() == "|" and one.get_color() == "black"]
    return [one.get_xdata() for one in sorted(found, key=lambda one: one.get_ydata()[0])]


def ticks(axis):
    """The labels of ticks within the axis: others are there, but not drawn."""
    low, high = sorted(axis.get_view_interval())
    return [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]


def columns(axes):
    """What stands beside the bars, from the top down."""
    texts = sorted(axes.texts, key=lambda one: (one.xy[1], one.xyann[0]))
    words = [one.get_text() for one in texts]
    return list(zip(words[::2], words[1::2], strict=True))


def test_each_bar_begins_where_the_one_below_it_ends():
    (axes,) = waterfall_figure([budget()]).axes
    found = rows(axes)
    assert [row[0] for row in found] == [
        *("total", "cause 1", "cause 2", "cause 0", "cause 3", "remainder"),
    ]
    assert found[0][1:3] == (0, pytest.approx(0.06))
    expected = [(0.01, 0.06), (0.03, 0.01), (0.02, 0.03), (0.0196, 0.02), (0, 0.0196)]
    np.testing.assert_allclose([row[1:3] for row in found[1:]], expected, atol=1e-15)


def test_causes_that_take_away_have_another_tone_and_a_key():
    figure = waterfall_figure([budget()])
    tones = {row[0]: row[3] for row in rows(figure.axes[0])}
    assert tones["cause 2"] == ORANGE.lower()
    assert tones["cause 0"] == tones["cause 1"] == BLUE.lower()
    assert len(figure.legends) == 1
    hatched = [bar for bar in figure.axes[0].patches if bar.get_hatch()]
    assert [bar.get_width() for bar in hatched] == [pytest.approx(-0.02)]
    assert not waterfall_figure([budget([0.01, 0.02])]).legends


def test_whiskers_stand_about_the_start_of_their_bar():
    (axes,) = waterfall_figure([budget()]).axes
    expected = [
        (0.054, 0.072),
        (0.01 + 0.048, 0.01 + 0.053),
        (0.03 - 0.022, 0.03 - 0.017),
        (0.02 + 0.008, 0.02 + 0.013),
        (0.0196 - 0.0016, 0.0196 + 0.0034),
    ]
    np.testing.assert_allclose(whiskers(axes), expected, atol=1e-15)
    low, high = axes.get_xlim()
    assert low <= np.min(expected)
    assert high >= np.max(expected)


def test_an_interval_need_not_hold_its_share():
    one = Budget("one", ["a"], [0.01], [[0.02, 0.03]], 0.01, (0.01, 0.01))
    (axes,) = waterfall_figure([one]).axes
    np.testing.assert_allclose(whiskers(axes)[1], [0.02, 0.03])


def test_roots_in_um_and_parts_of_the_total_stand_beside():
    (axes,) = waterfall_figure([budget()]).axes
    assert columns(axes) == [
        ("RMS, \N{MICRO SIGN}m", "of total"),
        ("245", "100 %"),
        ("224", "83 %"),
        ("\N{MINUS SIGN}141", "\N{MINUS SIGN}33 %"),
        ("100", "17 %"),
        ("20.0", "0.7 %"),
        ("140", "33 %"),
    ]


def test_small_squares_are_in_square_um():
    (axes,) = waterfall_figure([budget([1e-5, 2e-5], 3e-5)]).axes
    assert axes.get_xlabel() == "mean square, \N{MICRO SIGN}m\N{SUPERSCRIPT TWO}"
    assert rows(axes)[0][1:3] == (0, pytest.approx(30))
    (axes,) = waterfall_figure([budget([1e-5, 2e-5], 3e-5, unit="px")]).axes
    assert axes.get_xlabel() == "mean square, px\N{SUPERSCRIPT TWO}"
    assert rows(axes)[0][1:3] == (0, pytest.approx(3e-5))


def test_a_remainder_of_0_has_no_bar_and_one_below_0_has():
    (axes,) = waterfall_figure([budget([0.1, 0.2], 0.1 + 0.2)]).axes
    assert [row[0] for row in rows(axes)] == ["total", "cause 1", "cause 0"]
    (axes,) = waterfall_figure([budget([0.5, 0.8], 1.0, remainder="they overlap")]).axes
    assert rows(axes)[-1][:3] == ("they overlap", 0, pytest.approx(-0.3))


def test_panels_are_below_each_other_each_with_its_own_scale():
    figure = waterfall_figure([budget(), budget([1e-5, 2e-5], 3e-5, title="displacement")])
    above, below = figure.axes
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        *("position of the tip", "displacement"),
    ]
    figure.draw_without_rendering()
    assert above.get_window_extent().y0 > below.get_window_extent().y1
    assert above.get_window_extent().x0 == pytest.approx(below.get_window_extent().x0)
    assert above.get_xlim()[1] < 1 < below.get_xlim()[1]


@pytest.mark.parametrize(
    "budgets",
    [
        [budget(names=[LONG, "x" * 90, "a", LONG], title=LONG)],
        pytest.param(
            [budget(names=["a $ of b$"] * 4), budget(names=[LONG] * 4, title=LONG)],
            marks=pytest.mark.slow,
        ),
        pytest.param(
            [budget(np.linspace(-1, 2, 30), 40, names=[f"{k} {LONG}"[: 4 * k] for k in range(30)])],
            marks=pytest.mark.slow,
        ),
        [budget([0.0, 0.0], 0.0)],
        [budget([], 0.04)],
        [budget([4e4, -3.9e4], 1e3)],
    ],
)
def test_no_texts_overlap_each_other_or_a_bar(budgets):
    figure = waterfall_figure(budgets)
    figure.draw_without_rendering()
    texts, bars = [text for key in figure.legends for text in key.get_texts()], []
    for axes in figure.axes:
        texts += [*axes.texts, *ticks(axes.xaxis), *ticks(axes.yaxis)]
        texts += [axes.xaxis.label, axes.xaxis.get_offset_text(), axes._left_title]
        bars += [bar.get_window_extent() for bar in axes.patches]
        assert axes.get_window_extent().width > 0.35 * figure.bbox.width
    found = [one.get_window_extent() for one in texts if one.get_text()]
    assert len(found) > 8
    assert not any(a.overlaps(b) for a, b in itertools.combinations(found, 2))
    assert not any(a.overlaps(b) for a in found for b in bars if b.width > 0)
    inside = figure.bbox.padded(1)
    for box in found:
        assert inside.containsx(box.x0)
        assert inside.containsx(box.x1)
        assert inside.containsy(box.y0)
        assert inside.containsy(box.y1)


def test_names_are_no_formulas():
    figure = waterfall_figure([budget([0.01], names=["$x^2$ of a"])])
    assert rows(figure.axes[0])[1][0] == r"\$x^2\$ of a"
    assert png(figure).startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (lambda: waterfall_figure([]), "no budget"),
        (lambda: waterfall_figure([budget(names=["a"])]), "1 names do not go with"),
        (lambda: waterfall_figure([budget([0.1, np.nan])]), "not finite"),
        (lambda: waterfall_figure([budget(total=-1.0)]), "the mean square is -1"),
    ],
)
def test_what_is_no_budget_is_refused(call, problem):
    with pytest.raises(ValueError, match=problem):
        call()
