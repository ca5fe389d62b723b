"""Errors of repeated runs against the displacement (the paper's Fig. 13)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from simtip.capability.interval import Array, paired
from simtip.capability.repeatability import Repeatability
from simtip.report.runs import runs_of
from simtip.report.scale import MINUS, Scale, limits, number, scale_for
from simtip.report.style import GRAY, legend_above, new_figure, plain

BAND = 0.25
"""Opacity of the standard deviation."""


def repeatability_figure(
    measured: ArrayLike,
    reference: ArrayLike,
    parts: Sequence[object],
    runs: Sequence[object],
    found: Repeatability,
    *,
    unit: str = "mm",
) -> Figure:
    """Draw the errors of runs against the displacement, and below what departs from their mean.

    Parameters
    ----------
    measured, reference
        (n,) displacements.
    parts
        (n,) which displacement a value is a repetition of.
    runs
        (n,) which run it is of.
    found
        What `assess_repeatability` found for measured minus reference of these parts.
    unit
        Of the values; mm below 0.1 are shown as um.

    Raises
    ------
    ValueError
        Lengths differ or a number is not finite.
    """
    y, x = paired(measured, reference, 1)
    if len(parts) != len(y):
        raise ValueError(f"{len(parts)} parts do not go with {len(y)} values")
    part = _numbered(parts)
    counts = np.bincount(part)
    place, mean = (np.bincount(part, weights=values) / counts for values in (x, y - x))
    across = scale_for(x, unit)
    figure = new_figure(7.5, 6.2)
    figure.suptitle(_title(found, unit), fontsize=11)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.25, 1])
    _errors(above, (x, y - x), runs, (place, mean), found, (across, scale_for(y - x, unit)))
    repeated = counts[part] > 1
    _departures(below, (x, y - x - mean[part]), repeated, runs, found, across, unit)
    below.set_xlabel(f"displacement, {across.unit}")
    below.set_xlim(limits(across.of(x), margin=0.03))
    below.ticklabel_format(useOffset=False)
    figure.align_ylabels()
    return figure


def _numbered(parts: Sequence[object]) -> NDArray[np.intp]:
    number_of = {part: k for k, part in enumerate(dict.fromkeys(parts))}
    return np.array([number_of[part] for part in parts], dtype=np.intp)


def _title(found: Repeatability, unit: str) -> str:
    title = f"repeatability: {found.measurements} displacements"
    if found.p_t_percent is None or found.p_t_ci_percent is None or found.tolerance is None:
        return title
    low, high = found.p_t_ci_percent.low, found.p_t_ci_percent.high
    percent = [number(value, 1) for value in (found.p_t_percent, low, high)]
    return (
        f"{title}, P/T = {found.multiplier:g} SD / {found.tolerance:g} {unit} = "
        f"{percent[0]} % [{percent[1]}, {percent[2]}]"
    )


def _errors(
    axes: Axes,
    points: tuple[Array, Array],
    runs: Sequence[object],
    means: tuple[Array, Array],
    found: Repeatability,
    scales: tuple[Scale, Scale],
) -> None:
    across, scale = scales
    _draw_runs(axes, across.of(points[0]), scale.of(points[1]), runs)
    order = np.argsort(means[0])
    place, mean = means[0][order], means[1][order]
    axes.plot(across.of(place), scale.of(mean), color="black", lw=1.5, zorder=2.5, label="mean")
    # A single place has no width: its band goes from end to end.
    wide = across.of(place) if len(place) > 1 else np.array(limits(across.of(place)))
    low, high = (np.resize(scale.of(mean + sign * found.sigma), len(wide)) for sign in (-1, 1))
    axes.fill_between(wide, low, high, color=GRAY, alpha=BAND, lw=0, zorder=1)
    axes.set_ylim(limits(np.concatenate([scale.of(points[1]), low, high])))
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.set_ylabel(f"error, {scale.unit}")
    plain(axes)
    legend_above(axes)


def _departures(
    axes: Axes,
    points: tuple[Array, Array],
    repeated: NDArray[np.bool_],
    runs: Sequence[object],
    found: Repeatability,
    across: Scale,
    unit: str,
) -> None:
    """Draw what is left of errors less their part's mean; one of a part alone has none."""
    shown = np.where(repeated, points[1], np.nan)
    scale = scale_for(np.append(points[1], found.sigma), unit)
    sigma, ends = scale.factor * found.sigma, found.sigma_ci
    axes.axhline(0, color="black", lw=1.5, zorder=2.5)
    label = f"pooled SD {scale.text(found.sigma)} {scale.between(ends.low, ends.high)}"
    axes.axhspan(-sigma, sigma, color=GRAY, alpha=BAND, lw=0, zorder=1, label=label)
    legend_above(axes)
    _draw_runs(axes, across.of(points[0]), scale.of(shown), runs)
    axes.set_ylim(limits(np.append(scale.of(points[1]), [-sigma, sigma])))
    axes.set_ylabel(f"error {MINUS} mean, {scale.unit}")
    plain(axes)


def _draw_runs(axes: Axes, x: Array, y: Array, runs: Sequence[object]) -> None:
    for run in runs_of(runs, len(x)):
        rows = run.rows[np.argsort(x[run.rows], kind="stable")]
        axes.plot(x[rows], y[rows], lw=0.8, label=run.name, zorder=3, **run.look)
