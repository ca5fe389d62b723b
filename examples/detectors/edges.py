"""A detector as a plain Python function: ``--detector edges:lowest_dark``, run in this folder."""

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray


def lowest_dark(
    image: NDArray[np.uint8 | np.uint16],
    *,
    level: Annotated[float, "share of white below which a pixel is needle"] = 0.4,
    ties: Annotated[Literal["left", "mean", "right"], "which pixel of the lowest row"] = "mean",
) -> dict[str, object] | None:
    """Take the lowest dark pixel for the tip."""
    gray = image.mean(axis=2) if image.ndim == 3 else image
    rows, columns = np.nonzero(gray < level * np.iinfo(image.dtype).max)
    if rows.size == 0:
        return None  # no tip
    v = rows.max()
    us = columns[rows == v]
    u = {"left": us.min(), "mean": us.mean(), "right": us.max()}[ties]
    centroid = np.array([columns.mean(), rows.mean()])
    if np.allclose(centroid, (u, v)):
        return {"tip_px": (u, v)}
    # Any length will do for the axis, from the tip towards the hub.
    return {"tip_px": (u, v), "axis_px": centroid - (u, v)}
