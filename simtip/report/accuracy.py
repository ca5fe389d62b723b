"""Displacements by both methods, step by step, and their errors (the paper's Fig. 11)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from simtip.capability.interval import Array, paired
from simtip.report.scale import LEAST, Scale, limits, scale_for
from simtip.report.style import BLUE, ORANGE, legend_above, literal, new_figure, plain

FEW = 60
"""Steps; up to so many every one has a marker that is seen."""


def accuracy_figure(
    measured: ArrayLike,
    reference: ArrayLike,
    *,
    names: tuple[str, str] = ("vision", "interferometer"),
    unit: str = "mm",
) -> Figure:
    """Draw measured and reference displacements against the step number, and below the errors.

    Parameters
    ----------
    measured, reference
        (n,) displacements, one a step.
    names
        Of both methods.
    unit
        Of the displacements; mm below 0.1 are shown as um.

    Raises
    ------
    ValueError
        There is no step, lengths differ, or a number is not finite.
    """
    both = paired(measured, reference, 1)
    figure = new_figure(7.5, 5.6)
    figure.suptitle(f"accuracy: displacement in each of {len(both[0])} steps", fontsize=11)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.15, 1])
    _displacements(above, both, names, unit)
    _errors(below, both[0] - both[1], unit)
    below.set_xlabel("step")
    below.set_xlim(0.3, len(both[0]) + 0.7)
    below.xaxis.set_major_locator(MaxNLocator(15, steps=[1, 2, 5, 10], integer=True, min_n_ticks=1))
    figure.align_ylabels()
    return figure


def _displacements(
    axes: Axes, both: tuple[Array, Array], names: tuple[str, str], unit: str
) -> None:
    scale = scale_for(np.concatenate(both), unit)
    step = np.arange(1, len(both[0]) + 1)
    size = 6.5 if len(step) <= FEW else 3
    for values, name, color, marker, shrunk in (
        (both[0], names[0], BLUE, "o", 1.0),
        (both[1], names[1], ORANGE, "s", 0.8),
    ):
        axes.plot(
            step,
            scale.of(values),
            color=color,
            marker=marker,
            ms=size * shrunk,
            mec="white",
            mew=0.4,
            lw=1.2,
            label=literal(name),
        )
    axes.set_ylim(limits(scale.of(both), margin=0.1))
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.set_ylabel(f"displacement, {scale.unit}")
    legend_above(axes)
    plain(axes)


def _errors(axes: Axes, errors: Array, unit: str) -> None:
    scale = scale_for(errors, unit)
    step, shown = np.arange(1, len(errors) + 1), scale.of(errors)
    axes.bar(step, shown, width=0.62, color=BLUE, alpha=0.45)
    axes.axhline(0, color="black", lw=0.8)
    mean = float(errors.mean())
    axes.axhline(scale.factor * mean, color="black", lw=1.3, ls="--", label=_mean(errors, scale))
    worst = int(np.argmax(np.abs(errors)))
    axes.plot(
        [step[worst]],
        [shown[worst]],
        "o",
        ms=7,
        color=ORANGE,
        mec="white",
        mew=0.4,
        clip_on=False,
        zorder=4,
        label=f"largest {scale.text(errors[worst])}, step {step[worst]}",
    )
    axes.set_ylim(_around_zero(shown))
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.set_ylabel(f"error, {scale.unit}")
    legend_above(axes)
    plain(axes)
    axes.grid(visible=False, axis="x")


def _mean(errors: Array, scale: Scale) -> str:
    """Write the mean; of errors of both signs the mean size too, which is another number."""
    text = f"mean {scale.text(float(errors.mean()))}"
    if errors.min() < 0 < errors.max():
        text += f" (of sizes {scale.text(float(np.abs(errors).mean()))})"
    return text


def _around_zero(shown: Array) -> tuple[float, float]:
    """Give ends that hold 0, without room on the side of it where there is nothing."""
    low, high = limits(np.append(shown, 0.0), margin=0.12)
    if shown.min() >= -LEAST and shown.max() > LEAST:
        return 0.0, high
    if shown.max() <= LEAST and shown.min() < -LEAST:
        return low, 0.0
    return low, high
