"""An error budget: what each cause adds to the mean square, from the remainder to the total."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import ArrayLike

from simtip.capability.interval import RESOLUTION, Array
from simtip.report.scale import MICRO, digits, limits, number, scale_for
from simtip.report.style import BLUE, GRAY, ORANGE, SMALL, literal, new_figure

NAME_WIDTH, NAME_LINES = 26, 3
"""Letters of a line of a name, and lines; what is longer is cut."""

TITLE_WIDTH = 46

ROW_IN, LINE_IN = 0.3, 0.16
"""Height of a row whose name has one line, and of each further line, inches."""

FRAME_IN = 1.25
"""Height of what is above and below the rows of a panel, inches."""

TOTAL, REMAINDER = "#333333", "#AAAAAA"


@dataclass(frozen=True)
class Budget:
    """Causes of an error and their shares of its mean square.

    Attributes
    ----------
    title
        Of the panel.
    names
        (k,) of the causes.
    shares, intervals
        (k,) and (k, 2), in the square of the unit: what each cause adds to the mean square, below 0
        if it takes away; and both ends of each one's interval.
    total, total_interval
        The mean square, and both ends.
    unit
        Of the error; mm are shown as um where they are small.
    remainder
        What the total less all shares is called; there is no bar of one that is 0.
    """

    title: str
    names: Sequence[str]
    shares: ArrayLike
    intervals: ArrayLike
    total: float
    total_interval: tuple[float, float]
    unit: str = "mm"
    remainder: str = "remainder"


@dataclass(frozen=True)
class _Row:
    """A bar from start to start + share, its interval about the start if it has one."""

    name: str
    start: float
    share: float
    interval: tuple[float, float] | None
    color: str

    @property
    def lines(self) -> list[str]:
        return textwrap.wrap(self.name, NAME_WIDTH, max_lines=NAME_LINES, placeholder=" ..") or [""]

    @property
    def height(self) -> float:
        return ROW_IN + LINE_IN * (len(self.lines) - 1)


def waterfall_figure(budgets: Sequence[Budget]) -> Figure:
    """Draw budgets, one panel below the other.

    Bars of causes, the largest on top, lead from the remainder up to the total. Beside each stand
    the root of the size of its share, which adds up in squares only, and its part of the total.

    Raises
    ------
    ValueError
        There is no budget, or one's lengths differ or a number in it is not finite.
    """
    if not budgets:
        raise ValueError("there is no budget to draw")
    rows = [_rows(budget) for budget in budgets]
    heights = [FRAME_IN + sum(row.height for row in panel) for panel in rows]
    figure = new_figure(7.5, sum(heights))
    panels = figure.subplots(len(budgets), 1, squeeze=False, height_ratios=heights)[:, 0]
    for axes, budget, panel in zip(panels, budgets, rows, strict=True):
        _panel(axes, budget, panel)
    if any(row.color == ORANGE for panel in rows for row in panel):
        _legend(figure)
    return figure


def _rows(budget: Budget) -> list[_Row]:
    """Order the bars from the top."""
    shares, intervals = _checked(budget)
    order = np.argsort(-np.abs(shares), kind="stable")[::-1]
    start = budget.total - float(shares.sum())
    rows = []
    if abs(start) > RESOLUTION * max(abs(budget.total), float(np.abs(shares).max(initial=0.0))):
        rows.append(_Row(budget.remainder, 0.0, start, None, REMAINDER))
    for k in order:
        share, (low, high) = float(shares[k]), intervals[k]
        color = BLUE if share >= 0 else ORANGE
        rows.append(_Row(budget.names[k], start, share, (float(low), float(high)), color))
        start += share
    rows.append(_Row("total", 0.0, budget.total, budget.total_interval, TOTAL))
    return rows[::-1]


def _checked(budget: Budget) -> tuple[Array, Array]:
    shares = np.asarray(budget.shares, dtype=np.float64)
    intervals = np.asarray(budget.intervals, dtype=np.float64)
    count = len(budget.names)
    if shares.shape != (count,) or intervals.shape != (count, 2):
        raise ValueError(
            f"{count} names do not go with shares {shares.shape} and intervals {intervals.shape}"
        )
    if not all(np.isfinite(v).all() for v in (shares, intervals, budget.total_interval)):
        raise ValueError("a share or the end of an interval is not finite")
    if not (math.isfinite(budget.total) and budget.total >= 0):
        raise ValueError(f"the mean square is {budget.total:g}: it has to be a number from 0 on")
    return shares, intervals


def _panel(axes: Axes, budget: Budget, rows: Sequence[_Row]) -> None:
    scale = scale_for([math.sqrt(budget.total)], budget.unit)
    square = scale.factor**2
    heights = np.array([row.height for row in rows])
    at = np.cumsum(heights) - heights / 2
    for row, y in zip(rows, at, strict=True):
        _bar(axes, row, y, square)
    _steps(axes, rows, at, square)
    reach = [end for row in rows for end in _extent(row)]
    axes.set_xlim(limits([0.0, *(square * np.array(reach))], margin=0.03) if any(reach) else (0, 1))
    axes.set_ylim(heights.sum() + 0.04, -ROW_IN)
    axes.axvline(0, color="black", lw=0.8)
    axes.set_yticks(at, [literal("\n".join(row.lines)) for row in rows])
    axes.tick_params(axis="y", length=0)
    axes.get_yticklabels()[0].set_fontweight("bold")
    _columns(axes, budget, rows, at)
    axes.set_xlabel(literal(f"mean square, {scale.unit}\N{SUPERSCRIPT TWO}"))
    axes.ticklabel_format(axis="x", useOffset=False)
    axes.set_title(literal(textwrap.fill(budget.title, TITLE_WIDTH)), fontsize=11, loc="left")
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.grid(alpha=0.25, axis="x")
    axes.set_axisbelow(True)


def _extent(row: _Row) -> list[float]:
    whiskers = [] if row.interval is None else [row.start + end for end in row.interval]
    return [row.start + row.share, *whiskers]


def _bar(axes: Axes, row: _Row, y: float, square: float) -> None:
    axes.barh(
        y,
        square * row.share,
        left=square * row.start,
        height=0.6 * ROW_IN,
        color=row.color,
        hatch="////" if row.share < 0 else None,
        ec="white",
        lw=0,
    )
    if row.interval is None:
        return
    ends = square * (row.start + np.array(row.interval))
    # White beneath, so that the whisker is seen on the bar too.
    for color, width in (("white", 2.6), ("black", 1.1)):
        axes.plot(ends, [y, y], color=color, lw=width, marker="|", ms=6, mew=width, zorder=3)


def _steps(axes: Axes, rows: Sequence[_Row], at: Array, square: float) -> None:
    """Join the end of each bar with the start of the one above it."""
    for k in range(1, len(rows)):
        end = square * (rows[k].start + rows[k].share)
        axes.plot([end, end], at[[k - 1, k]], color=GRAY, lw=0.8, zorder=0.9)


def _columns(axes: Axes, budget: Budget, rows: Sequence[_Row], at: Array) -> None:
    """Write the numbers in two columns, clear of all bars."""
    small, unit = (1e3, MICRO) if budget.unit == "mm" else (1.0, budget.unit)
    texts = [(f"RMS, {literal(unit)}", "of total")]
    texts += [(_root(small, row.share), _percent(row.share, budget.total)) for row in rows]
    for y, pair in zip([-0.4 * ROW_IN, *at], texts, strict=True):
        for text, right in zip(pair, (54, 106), strict=True):
            axes.annotate(
                text,
                (1.0, y),
                (right, 0),
                xycoords=axes.get_yaxis_transform(),
                textcoords="offset points",
                ha="right",
                va="center_baseline",
                fontsize=SMALL,
                color=GRAY if y < 0 else "black",
            )


def _root(factor: float, share: float) -> str:
    root = factor * math.sqrt(abs(share))
    return number(math.copysign(root, share), min(digits(root), 2) if root else 0)


def _percent(share: float, total: float) -> str:
    if total == 0:
        return "\N{EN DASH}"
    percent = 100 * share / total
    return f"{number(percent, 0 if abs(percent) >= 9.95 else 1)} %"


def _legend(figure: Figure) -> None:
    figure.legend(
        handles=[
            Patch(fc=BLUE, label="adds to the error"),
            Patch(fc=ORANGE, ec="white", hatch="////", lw=0, label="takes away from it"),
        ],
        frameon=False,
        fontsize=SMALL,
        loc="outside lower center",
        ncols=2,
    )
