"""Points, lines and bands are read back from the figures, in the unit that the axes name."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Annotation, Text

from simtip.capability import assess_agreement, assess_repeatability
from simtip.capability.interval import Interval
from simtip.report.accuracy import accuracy_figure
from simtip.report.bland_altman import bland_altman_figure
from simtip.report.repeatability import repeatability_figure
from simtip.report.style import png

X = np.tile(np.arange(2.0, 29, 2), 5)
PARTS, RUNS = np.tile(np.arange(14), 5).tolist(), np.repeat(np.arange(1, 6), 14).tolist()


def noisy(bias, sd, seed=1):
    return X + bias + np.random.default_rng(seed).normal(0, sd, X.size)


def lines(axes, **look):
    """Those with points or with a marker, by what is asked of them."""
    return [
        one for one in axes.lines if all(getattr(one, f"get_{k}")() == v for k, v in look.items())
    ]


def level(line):
    """The height of a line that goes from edge to edge."""
    (height,) = set(np.asarray(line.get_ydata(), float))
    return height


def band(patch):
    box = patch.get_bbox()
    return box.y0, box.y1


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def boxes(figure, texts):
    figure.draw_without_rendering()
    # Of an annotation itself the line that leads to it would count too.
    return [Text.get_window_extent(text) for text in texts]


def apart(figure, texts):
    found = boxes(figure, [text for text in texts if text.get_text()])
    inside = figure.bbox.padded(1)
    assert len(found) > 1
    assert all(inside.containsx(b.x0) and inside.containsx(b.x1) for b in found)
    assert all(inside.containsy(b.y0) and inside.containsy(b.y1) for b in found)
    return not any(a.overlaps(b) for a, b in itertools.combinations(found, 2))


def test_steps_and_their_errors_are_drawn_with_mean_and_largest():
    measured, reference = np.array([2.3, 1.9, 2.25]), np.array([2.0, 2.1, 2.0])
    above, below = accuracy_figure(measured, reference, names=("a$b$", "c")).axes
    first, second = above.lines
    np.testing.assert_array_equal(first.get_xydata(), np.column_stack([[1, 2, 3], measured]))
    np.testing.assert_array_equal(second.get_ydata(), reference)
    assert legend(above) == [r"a\$b\$", "c"]
    errors = measured - reference
    np.testing.assert_allclose([bar.get_height() for bar in below.patches], errors)
    (mean,) = lines(below, linestyle="--")
    assert level(mean) == pytest.approx(errors.mean())
    (worst,) = lines(below, marker="o")
    assert worst.get_xydata().tolist() == [[1, pytest.approx(0.3)]]
    assert legend(below) == [
        "mean 0.117 mm (of sizes 0.250 mm)",
        "largest 0.300 mm, step 1",
    ]
    assert above.get_ylabel() == "displacement, mm"


def test_the_largest_error_may_be_below_0_and_small_ones_are_in_um():
    _, below = accuracy_figure([2.0, 2.0, 2.0], [2.01, 2.0502, 2.0]).axes
    assert below.get_ylabel() == "error, \N{MICRO SIGN}m"
    assert min(bar.get_height() for bar in below.patches) == pytest.approx(-50.2)
    assert legend(below)[1] == "largest \N{MINUS SIGN}50.2 \N{MICRO SIGN}m, step 2"
    assert legend(below)[0].startswith("mean \N{MINUS SIGN}20.1")
    # 0 is the end of the axis: nothing is above it.
    assert below.get_ylim()[1] == 0


def test_only_millimetres_become_micrometres():
    _, below = accuracy_figure([2.0, 2.0], [2.01, 2.0502], unit="in").axes
    assert below.get_ylabel() == "error, in"
    assert min(bar.get_height() for bar in below.patches) == pytest.approx(-0.0502)


def test_differences_bias_and_limits_are_where_they_were_found():
    y = noisy(0.29, 0.07)
    found = assess_agreement(y, X)
    (axes,) = bland_altman_figure(y, X, found, runs=RUNS).axes
    points = lines(axes, linestyle="None")
    assert len(points) == 5
    assert len({one.get_color() for one in points}) == 5
    assert len({one.get_marker() for one in points}) == 5
    for k, one in enumerate(points):
        rows = slice(14 * k, 14 * k + 14)
        expected = np.column_stack([(y + X)[rows] / 2, (y - X)[rows]])
        np.testing.assert_allclose(one.get_xydata(), expected)
        assert one.get_label() == f"run {k + 1}"
    limits = found.limits
    assert sorted(map(level, lines(axes, linestyle="--"))) == [limits.lower, limits.upper]
    assert limits.bias in map(level, lines(axes, linestyle="-"))
    expected = [(one.low, one.high) for one in (limits.bias_ci, limits.lower_ci, limits.upper_ci)]
    np.testing.assert_allclose([band(patch) for patch in axes.patches], expected)
    texts = [one.get_text() for one in axes.texts]
    assert [text.splitlines()[:2] for text in texts] == [
        ["upper limit (95 %)", f"{limits.upper:.3f} mm"],
        ["bias", f"{limits.bias:.3f} mm"],
        ["lower limit (95 %)", f"{limits.lower:.3f} mm"],
    ]
    assert texts[1].endswith(f"[{limits.bias_ci.low:.3f}, {limits.bias_ci.high:.3f}]")


@pytest.mark.parametrize(("slope", "drawn"), [(0.0, False), (0.02, True)])
def test_a_line_is_drawn_if_the_bias_is_proportional(slope, drawn):
    y = noisy(0.29, 0.07) + slope * X
    found = assess_agreement(y, X)
    assert (found.proportional.slope_p < 0.05) == drawn
    (axes,) = bland_altman_figure(y, X, found).axes
    sloped = lines(axes, linestyle="-.")
    assert len(sloped) == drawn
    for one in sloped:
        x, d = one.get_data()
        np.testing.assert_allclose(d, found.proportional.intercept + found.proportional.slope * x)
        assert (x.min(), x.max()) == (((y + X) / 2).min(), ((y + X) / 2).max())
        assert legend(axes) == [f"slope +{found.proportional.slope:.2g}, p < 0.001"]


def test_bands_without_end_stop_at_the_axis():
    found = assess_agreement([2.3, 4.25, 6.31], [2, 4, 6])
    endless = replace(found.limits, upper_ci=Interval(0.3, np.inf))
    (axes,) = bland_altman_figure([2.3, 4.25, 6.31], [2, 4, 6], replace(found, limits=endless)).axes
    assert band(axes.patches[2]) == (pytest.approx(0.3), axes.get_ylim()[1])
    assert axes.texts[0].get_text().endswith("inf]")
    # Points are not pressed together by intervals many times as wide.
    assert np.ptp([one.get_ydata() for one in lines(axes, linestyle="None")]) > 0.1 * np.ptp(
        axes.get_ylim()
    )


def test_0_is_shown_if_it_is_near():
    for bias, shown in ((0.29, True), (3.0, False)):
        y = noisy(bias, 0.07)
        (axes,) = bland_altman_figure(y, X, assess_agreement(y, X)).axes
        low, high = axes.get_ylim()
        assert (low < 0 < high) == shown
        assert (0 in map(level, lines(axes, linestyle="-"))) == shown


@pytest.mark.parametrize(
    ("times", "sd", "pushed"), [(1, 0.0, 0.0), (1, 0.01, 3.0), (10, 0.01, 3.0), (10, 0.01, -3.0)]
)
def test_texts_at_the_edge_are_apart_however_close_their_lines(times, sd, pushed):
    y, x = np.tile(noisy(0.3, sd), times), np.tile(X, times)
    y[7] += pushed
    names = ("silhouette in both images, refined", "interferometer along the axis of the stage")
    runs = [f"operator {run}, day 3" for run in RUNS] * times
    figure = bland_altman_figure(y, x, assess_agreement(y, x), runs=runs, names=names)
    (axes,) = figure.axes
    texts = [one for one in axes.texts if isinstance(one, Annotation)]
    assert len(texts) == 3
    around = [figure._suptitle, axes.xaxis.label, axes.yaxis.label]
    assert apart(figure, [*texts, *axes.get_legend().get_texts(), *around])
    assert axes.get_window_extent().width > 0.6 * figure.bbox.width


def test_runs_their_mean_and_the_pooled_deviation_are_drawn():
    error = noisy(0.29, 0.017) - X + 0.04 * np.sin(X)
    found = assess_repeatability(error, PARTS, tolerance=0.62)
    shuffled = np.random.default_rng(3).permutation(X.size)
    figure = repeatability_figure(
        (X + error)[shuffled],
        X[shuffled],
        [PARTS[k] for k in shuffled],
        [RUNS[k] for k in shuffled],
        found,
    )
    above, below = figure.axes
    by_run = error.reshape(5, 14)
    drawn = {one.get_label(): one for one in above.lines}
    for k in range(5):
        np.testing.assert_array_equal(drawn[f"run {k + 1}"].get_xdata(), X[:14])
        np.testing.assert_allclose(drawn[f"run {k + 1}"].get_ydata(), by_run[k])
    mean = by_run.mean(axis=0)
    np.testing.assert_allclose(drawn["mean"].get_ydata(), mean)
    (edge,) = (one.get_paths()[0].vertices for one in above.collections)
    for x, middle in zip(X[:14], mean, strict=True):
        heights = edge[edge[:, 0] == x, 1]
        assert heights.min() == pytest.approx(middle - found.sigma)
        assert heights.max() == pytest.approx(middle + found.sigma)
    assert band(below.patches[0]) == pytest.approx((-1e3 * found.sigma, 1e3 * found.sigma))
    left = {one.get_label(): one.get_ydata() for one in below.lines}
    np.testing.assert_allclose(left["run 4"], 1e3 * (by_run[3] - mean), atol=1e-9)
    percent = 100 * 6 * found.sigma / 0.62
    assert f"P/T = 6 SD / 0.62 mm = {percent:.1f} % [" in figure.get_suptitle()
    assert legend(below)[0].startswith(f"pooled SD {1e3 * found.sigma:.1f} \N{MICRO SIGN}m [")


def test_without_tolerance_there_is_no_ratio():
    found = assess_repeatability([0.1, 0.2, 0.1], "aab")
    figure = repeatability_figure([2.1, 2.2, 4.1], [2, 2, 4], "aab", [1, 2, 1], found)
    assert figure.get_suptitle() == "repeatability: 2 displacements"
    # The third was not repeated: nothing departs from a mean of one.
    left = {one.get_label(): one.get_ydata() for one in figure.axes[1].lines}
    np.testing.assert_allclose(left["run 1"], [-50, np.nan])


def test_a_single_displacement_has_a_band_too():
    errors = np.array([0.1, 0.14, 0.12])
    found = assess_repeatability(errors, "aaa", tolerance=1)
    above, below = repeatability_figure(2 + errors, [2, 2, 2], "aaa", [1, 2, 3], found).axes
    edge = above.collections[0].get_paths()[0].vertices
    assert np.ptp(edge[:, 0]) == pytest.approx(0.4)
    assert edge[:, 1].min() == pytest.approx(0.12 - found.sigma)
    assert below.get_xlim() == (1.8, 2.2)


def test_more_runs_than_can_be_told_apart_look_alike():
    runs = np.repeat(np.arange(35), 2).tolist()
    y = noisy(0.29, 0.07)
    (axes,) = bland_altman_figure(y, X, assess_agreement(y, X), runs=runs).axes
    assert legend(axes) == ["35 runs"]
    assert len({one.get_color() for one in lines(axes, linestyle="None")}) == 1


@pytest.mark.parametrize(
    ("measured", "reference"),
    [
        pytest.param(X + 0.3, X, marks=pytest.mark.slow),
        pytest.param(X, X, marks=pytest.mark.slow),
        ([2.1, 2.3, 1.9], [2.0, 2.0, 2.0]),
        ([1e-6, 2e-6, 4e-6], [0.0, 0.0, 0.0]),
        pytest.param(
            np.linspace(1, 30, 200) + 0.01, np.linspace(1, 30, 200), marks=pytest.mark.slow
        ),
    ],
)
def test_edges_are_drawn_with_axes_that_can_be_read(measured, reference):
    measured, reference = np.array(measured), np.array(reference)
    count = len(measured)
    parts = (np.arange(count) // 2).tolist()
    found = assess_repeatability(measured - reference, parts, tolerance=1)
    figures = [
        accuracy_figure(measured, reference),
        bland_altman_figure(measured, reference, assess_agreement(measured, reference)),
        repeatability_figure(measured, reference, parts, [0] * count, found),
    ]
    for figure in figures:
        figure.draw_without_rendering()
        for axes in figure.axes:
            labels = [*axes.get_xticklabels(), *axes.get_yticklabels()]
            assert max(len(label.get_text()) for label in labels) <= 8
            assert axes.yaxis.get_offset_text().get_text() == ""


def test_they_become_files():
    figure = bland_altman_figure(X + 0.3, X, assess_agreement(X + 0.3, X), runs=RUNS)
    assert png(figure).startswith(b"\x89PNG")


def test_zero_errors_are_0_and_not_rounding():
    _, below = accuracy_figure(X + 0.1 - 0.1, X).axes
    assert legend(below)[0] == "mean 0 \N{MICRO SIGN}m"
    assert below.get_ylim() == pytest.approx((-1, 1))


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (lambda: accuracy_figure([2, 2], [2, 2, 2]), "do not pair with"),
        (lambda: accuracy_figure([2, np.nan], [2, 2]), "finite"),
        (
            lambda: bland_altman_figure(X, X, assess_agreement(X, X), runs=[1]),
            "1 runs do not go with 70 values",
        ),
        (
            lambda: repeatability_figure(X, X, [1], RUNS, assess_repeatability(X, PARTS)),
            "1 parts do not go with 70 values",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(call, problem):
    with pytest.raises(ValueError, match=problem):
        call()
