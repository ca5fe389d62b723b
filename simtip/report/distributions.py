"""How errors are spread, group by group."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from simtip.geometry import Array
from simtip.report.scale import scale_for
from simtip.report.style import BLUE, literal, new_figure, plain

BINS = 60
LONGEST = 28


def distributions_figure(groups: Sequence[tuple[str, Array]]) -> Figure:
    """Draw a histogram of each group's lengths, with its median, and 5 to 95 %.

    Parameters
    ----------
    groups
        Names, and (n,) lengths, mm; n at least 1.
    """
    everything = np.concatenate([values for _, values in groups])
    scale = scale_for(everything)
    edges = np.histogram_bin_edges(scale.of(everything), BINS)
    figure = new_figure(7.5, 1.0 + 0.8 * len(groups))
    every = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, values) in zip(every, groups, strict=True):
        shown = scale.of(values)
        axes.hist(shown, edges.tolist(), histtype="stepfilled", color=BLUE, alpha=0.35)
        axes.hist(shown, edges.tolist(), histtype="step", color=BLUE, lw=1)
        low, middle, high = np.percentile(shown, [5, 50, 95])
        axes.plot([low, high], [0, 0], color="black", lw=2.4, clip_on=False)
        axes.plot([middle], [0], "o", ms=6, mfc="white", mec="black", clip_on=False, zorder=4)
        short = name if len(name) <= LONGEST else f"{name[: LONGEST - 2]}.."
        axes.set_title(literal(f"{short}: {len(values)} trials"), fontsize=10, loc="left")
        axes.set_ylim(0, None)
        plain(axes)
    every[-1].set_xlabel(f"error, {scale.unit}; dot: median, line: 5 to 95 %")
    return figure
