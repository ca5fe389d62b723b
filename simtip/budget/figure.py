"""A budget's picture: what every cause adds to the mean square error."""

from __future__ import annotations

from simtip.budget.errors import FROM_START, POSITION, STEP
from simtip.budget.run import Budget
from simtip.report.style import png
from simtip.report.waterfall import Budget as Panel
from simtip.report.waterfall import waterfall_figure

TITLES = {
    POSITION: "absolute position of the tip",
    STEP: "displacement, from one position to the next",
    FROM_START: "displacement, from the run's start",
}


def budget_figure(budget: Budget) -> bytes:
    """Give the picture of all kinds of error, as PNG."""
    panels = [
        Panel(
            title=TITLES[kind],
            names=[str(cause) for cause in budget.causes],
            shares=shares.shapley[:, 0],
            intervals=shares.shapley[:, 1:],
            total=float(shares.total[0]),
            total_interval=(float(shares.total[1]), float(shares.total[2])),
        )
        for kind, shares in budget.shares.items()
    ]
    return png(waterfall_figure(panels))
