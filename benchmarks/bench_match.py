"""How many pairs of tips a second are matched, one by one and in bulk, against OpenCV's lines.

The measure in bulk is `cv2.computeCorrespondEpilines` in both directions, with the distances by
NumPy. One thread.

    python benchmarks/bench_match.py [--quick]
"""

from __future__ import annotations

import cv2
import numpy as np
from environment import best_s, each_s, parser, report
from pairs import tip_pairs

from simtip.geometry import Array
from simtip.match import distance_to_line, epipolar_distances, match_tips


def by_opencv(left: Array, right: Array, F: Array) -> Array:
    """Give the symmetric distances (n,) px with OpenCV's epipolar lines."""
    # OpenCV's F is the transpose: p_2^T F p_1 = 0, with image 1 the left one.
    in_right = cv2.computeCorrespondEpilines(left.reshape(-1, 1, 2), 1, F.T).reshape(-1, 3)
    in_left = cv2.computeCorrespondEpilines(right.reshape(-1, 1, 2), 2, F.T).reshape(-1, 3)
    return (distance_to_line(left, in_left) + distance_to_line(right, in_right)) / 2


def main() -> None:
    """Measure and print."""
    quick = parser(__doc__).parse_args().quick
    count, repeats = (1_000, 1) if quick else (100_000, 9)
    cv2.setNumThreads(1)
    rig, _, left, right = tip_pairs(count)
    F = rig.fundamental()
    single_s = each_s(lambda: match_tips(left[0], right[0], rig), repeats)
    bulk_s = best_s(lambda: epipolar_distances(left, right, rig), repeats)
    opencv_s = best_s(lambda: by_opencv(left, right, F), repeats)
    here = np.mean(epipolar_distances(left, right, rig), axis=0)
    report(
        "match",
        quick=quick,
        pairs=count,
        repeats=repeats,
        match_tips_pairs_per_s=1 / single_s,
        epipolar_distances_pairs_per_s=count / bulk_s,
        opencv_pairs_per_s=count / opencv_s,
        ratio_to_opencv=bulk_s / opencv_s,
        largest_difference_px=float(np.abs(here - by_opencv(left, right, F)).max()),
    )


if __name__ == "__main__":
    main()
