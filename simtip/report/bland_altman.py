"""Differences of two methods against their means (the paper's Fig. 12)."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from simtip.capability.agreement import Agreement
from simtip.capability.interval import Array, Interval, paired
from simtip.capability.regression import Regression
from simtip.report.runs import runs_of
from simtip.report.scale import MINUS, Scale, limits, scale_for
from simtip.report.style import BLUE, SMALL, legend_above, literal, new_figure, plain

SIGNIFICANT = 0.05
"""A proportional bias is drawn if its p value is below."""

WIDEST = 3.0
"""Half the axis at most, in halves of what points and limits span: intervals of few pairs are wide
beyond all measure, and their numbers stand beside."""

APART, INSIDE = 0.15, 0.05
"""Least distance between texts at the right edge, and from the ends, in heights of the axes."""

LABEL_WIDTH = 46
"""Letters of a line of a label."""


def bland_altman_figure(
    measured: ArrayLike,
    reference: ArrayLike,
    agreement: Agreement,
    *,
    runs: Sequence[object] | None = None,
    names: tuple[str, str] = ("vision", "interferometer"),
    unit: str = "mm",
) -> Figure:
    """Draw measured minus reference against their mean, with bias and limits of agreement.

    Bands are the confidence intervals of the lines in them.

    Parameters
    ----------
    measured, reference
        (n,) pairs.
    agreement
        What `assess_agreement` found for them.
    runs
        (n,) which run a pair is of, or None.
    names
        Of both methods.
    unit
        Of the values; mm below 0.1 are shown as um.

    Raises
    ------
    ValueError
        Lengths differ or a number is not finite.
    """
    y, x = paired(measured, reference, 1)
    found = agreement.limits
    scale = scale_for(np.array([*(y - x), found.lower, found.upper]), unit)
    across = scale_for(np.concatenate([y, x]), unit)
    figure = new_figure(7.5, 5.2)
    axes = figure.subplots()
    axes.set_ylim(_reach(y - x, agreement, scale))
    axes.set_xlim(limits(across.of((y + x) / 2), margin=0.05))
    if axes.get_ylim()[0] < 0 < axes.get_ylim()[1]:
        axes.axhline(0, color="black", lw=0.6)
    _lines(axes, agreement, scale)
    count = 0
    for run in runs_of(runs, len(y)):
        d, mean = (y - x)[run.rows], ((y + x) / 2)[run.rows]
        axes.plot(across.of(mean), scale.of(d), ls="", label=run.name, zorder=3, **run.look)
        count += 1
    _proportional(axes, agreement.proportional, (y + x) / 2, across, scale)
    axes.set_xlabel(_label(f"mean of {names[0]} and {names[1]}, {across.unit}"))
    axes.set_ylabel(_label(f"{names[0]} {MINUS} {names[1]}, {scale.unit}"))
    of_runs = f" in {count} runs" if count > 1 else ""
    figure.suptitle(f"agreement: {len(y)} differences{of_runs}", fontsize=11)
    axes.ticklabel_format(useOffset=False)
    plain(axes)
    legend_above(axes)
    return figure


def _label(text: str) -> str:
    return literal(textwrap.fill(text, LABEL_WIDTH))


def _reach(d: Array, agreement: Agreement, scale: Scale) -> tuple[float, float]:
    """Give the ends of the axis; 0 is within if that does not cost a third of it."""
    found = agreement.limits
    inner = np.array([*d, found.lower, found.upper])
    centre, half = (inner.max() + inner.min()) / 2, float(np.ptp(inner)) / 2
    ends = np.clip(
        [found.lower_ci.low, found.upper_ci.high, *inner],
        centre - WIDEST * half,
        centre + WIDEST * half,
    )
    if max(ends.min(), -ends.max()) < np.ptp(ends) / 2:
        ends = np.append(ends, 0.0)
    return limits(scale.of(ends))


def _lines(axes: Axes, agreement: Agreement, scale: Scale) -> None:
    found = agreement.limits
    share = f"{100 * agreement.share:g} %"
    axes.axhline(scale.factor * found.bias, color="black", lw=1.5)
    for limit in (found.lower, found.upper):
        axes.axhline(scale.factor * limit, color="black", lw=1.2, ls="--")
    for interval, color, alpha in (
        (found.bias_ci, "black", 0.16),
        (found.lower_ci, BLUE, 0.13),
        (found.upper_ci, BLUE, 0.13),
    ):
        low, high = np.clip(scale.of([interval.low, interval.high]), *axes.get_ylim())
        axes.axhspan(low, high, color=color, alpha=alpha, lw=0, zorder=0.5)
    _texts(
        axes,
        [
            (found.upper, found.upper_ci, f"upper limit ({share})"),
            (found.bias, found.bias_ci, "bias"),
            (found.lower, found.lower_ci, f"lower limit ({share})"),
        ],
        scale,
    )


def _texts(axes: Axes, lines: Sequence[tuple[float, Interval, str]], scale: Scale) -> None:
    """Write values at the right edge, moved apart where lines are closer than texts are high."""
    low, high = axes.get_ylim()
    upper, middle, lower = ((scale.factor * line[0] - low) / (high - low) for line in lines)
    centre = float(np.clip(middle, INSIDE + APART, 1 - INSIDE - APART))
    places = (
        float(np.clip(upper, centre + APART, 1 - INSIDE)),
        centre,
        float(np.clip(lower, INSIDE, centre - APART)),
    )
    for at, place, (value, interval, name) in zip(
        (upper, middle, lower), places, lines, strict=True
    ):
        axes.annotate(
            f"{name}\n{scale.text(value)}\n{scale.between(interval.low, interval.high)}",
            (1.0, at),
            (1.035, place),
            xycoords="axes fraction",
            textcoords="axes fraction",
            va="center",
            fontsize=SMALL,
            linespacing=1.15,
            arrowprops={
                "arrowstyle": "-",
                "lw": 0.8,
                "color": "black",
                "relpos": (0, 0.5),
                "shrinkA": 2,
                "shrinkB": 0,
            },
        )


def _proportional(
    axes: Axes, line: Regression | None, mean: Array, across: Scale, scale: Scale
) -> None:
    if line is None or line.slope_p is None or line.slope_p >= SIGNIFICANT:
        return
    x = np.array([mean.min(), mean.max()])
    p = "p < 0.001" if line.slope_p < 1e-3 else f"p = {line.slope_p:.2g}"
    slope = f"{line.slope:+.2g}".replace("-", MINUS)
    axes.plot(
        across.of(x),
        scale.of(line.intercept + line.slope * x),
        color="black",
        lw=1.6,
        ls="-.",
        zorder=4,
        label=f"slope {slope}, {p}",
    )
