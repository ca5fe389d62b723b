"""Errors before and after a change of the detector, condition by condition."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from simtip.report.scale import limits
from simtip.report.style import BLUE, GRAY, ORANGE, SMALL, legend_above, literal, new_figure, plain

LONGEST = 38
SIDES = ("left", "right")


@dataclass(frozen=True)
class Bias:
    """One condition's errors along the needle, px: mean and SD, before and now, by view.

    What is None was not there.
    """

    name: str
    state: str
    before: dict[str, tuple[float, float] | None]
    now: dict[str, tuple[float, float] | None]


def changes_figure(conditions: Sequence[Bias]) -> Figure:
    """Draw both views' errors along the needle, from before to now.

    Raises
    ------
    ValueError
        There is no condition.
    """
    if not conditions:
        raise ValueError("there is no condition to draw")
    figure = new_figure(9.5, 1.3 + 0.32 * len(conditions))
    for axes, side in zip(figure.subplots(1, 2, sharey=True), SIDES, strict=True):
        _panel(axes, conditions, side)
        axes.set_xlabel(f"error along, {side} view, px")
    figure.axes[0].set_yticks(
        range(len(conditions)), [_cut(condition.name) for condition in conditions]
    )
    figure.axes[0].tick_params(axis="y", length=0, labelsize=SMALL)
    legend_above(figure.axes[0])
    return figure


def _panel(axes: Axes, conditions: Sequence[Bias], side: str) -> None:
    reach = [0.0]
    for y, condition in enumerate(conditions):
        before, now = condition.before[side], condition.now[side]
        color = ORANGE if condition.state == "worse" else BLUE
        if before is not None and now is not None:
            axes.plot([before[0], now[0]], [y, y], color=color, lw=1.2, alpha=0.6, zorder=1)
        for told, filled in ((before, False), (now, True)):
            if told is None:
                continue
            mean, sd = told
            reach += [mean - sd, mean + sd]
            axes.plot([mean - sd, mean + sd], [y, y], color=GRAY, lw=3, alpha=0.35, zorder=0)
            axes.plot(
                [mean], [y], "o", ms=6.5, mfc=color if filled else "white", mec=color, mew=1.4
            )
    axes.axvline(0, color="black", lw=0.8)
    for label, face in (("before", "white"), ("now", BLUE)):
        axes.plot([], [], "o", ms=6.5, mfc=face, mec=BLUE, mew=1.4, label=label)
    axes.plot([], [], "o", ms=6.5, color=ORANGE, label="now, worse")
    axes.set_xlim(limits(np.array(reach)))
    axes.set_ylim(len(conditions) - 0.4, -0.6)
    plain(axes)
    axes.grid(visible=False, axis="y")


def _cut(name: str) -> str:
    return literal(name if len(name) <= LONGEST else f"{name[: LONGEST - 2]}..")
