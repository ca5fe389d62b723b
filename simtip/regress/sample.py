"""What a detector found under one condition, as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array

VIEWS = ("left", "right")
AXES = ("u", "v")
NEEDLE_AXES = ("along", "across")

GROSS_PX = 3.0
GROSS_SIGMAS = 10.0
MAD_TO_SIGMA = 1.4826


@dataclass(frozen=True, eq=False)
class Sample:
    """The trials of one condition, in their order.

    Attributes
    ----------
    found
        (n,) whether a tip was measured.
    error_px
        (n, 2, 2) of both views, u and v, measured - true; NaN where no tip was seen.
    axis_px
        (2, 2) of both views, the needle's true direction, of length 1.
    in_view
        Of both views, whether the true tip lies in the image: else a tip seen there is wrong.
    """

    found: NDArray[np.bool_]
    error_px: Array
    axis_px: Array
    in_view: tuple[bool, bool] = (True, True)

    def __len__(self) -> int:
        """Give the number of trials."""
        return len(self.found)

    @cached_property
    def needle_px(self) -> Array:
        """Errors along and across the needle, (n, 2, 2)."""
        along = np.einsum("nva,va->nv", self.error_px, self.axis_px)
        turned = np.stack([-self.axis_px[:, 1], self.axis_px[:, 0]], axis=1)
        return np.stack([along, np.einsum("nva,va->nv", self.error_px, turned)], axis=2)

    @cached_property
    def detected(self) -> Array:
        """How much of each pair was detected, (n,): 0 to 1 in thirds, for each tip and the match.

        So a tip that is lost counts even where the pair had no match before. Where the true tip is
        out of view, it counts that none is found.
        """
        told = ((self.seen(0), self.in_view[0]), (self.seen(1), self.in_view[1]))
        right = [(seen == true) * 1.0 for seen, true in (*told, (self.found, all(self.in_view)))]
        detected: Array = (right[0] + right[1] + right[2]) / 3
        return detected

    def seen(self, view: int) -> NDArray[np.bool_]:
        """Say in which trials there is a tip in a view."""
        return np.asarray(~np.isnan(self.error_px[:, view, 0]))


def gross(before: Sample, after: Sample) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Say which tips lie far off all others, before and after: (n, 2) and (m, 2) by view.

    Far is more than 3 px and 10 robust standard deviations from the median of both together, so
    that neither side is judged by the other. If most of one side moved, none is.
    """
    together = np.concatenate([before.error_px, after.error_px])
    marks = np.zeros(together.shape[:2], dtype=np.bool_)
    for view in range(2):
        places = together[:, view]
        seen = ~np.isnan(places[:, 0])
        if seen.sum() < 3:
            continue
        centre = np.median(places[seen], axis=0)
        far = np.linalg.norm(places[seen] - centre, axis=1)
        limit = max(GROSS_PX, GROSS_SIGMAS * MAD_TO_SIGMA * float(np.median(far)))
        marks[seen, view] = far > limit
    split = len(before)
    # A shift as large as that is no outlier.
    for part in (slice(None, split), slice(split, None)):
        for view in range(2):
            seen = ~np.isnan(together[part, view, 0])
            if marks[part, view].sum() > 0.5 * max(int(seen.sum()), 1):
                marks[:, view] = False
    return marks[:split], marks[split:]
