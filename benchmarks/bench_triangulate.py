"""How many pairs a second each method triangulates, against `cv2.triangulatePoints`.

In bulk: `triangulate_points`, against OpenCV on the same array. One by one: `triangulate`, with its
checks, depths and residuals, against OpenCV called with one pair. `optimal` has a second measure,
`cv2.correctMatches` before `cv2.triangulatePoints`, which is the same method. Ratios are time over
OpenCV's time. One thread.

    python benchmarks/bench_triangulate.py [--quick]
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from environment import best_s, each_s, parser, report
from pairs import tip_pairs

from simtip.camera import StereoRig
from simtip.geometry import Array
from simtip.triangulate import METHODS, triangulate, triangulate_points


class OpenCV:
    """OpenCV's triangulation for a rig without distortion."""

    def __init__(self, rig: StereoRig) -> None:
        to_right = rig.T_lr.inverse()
        self._left = rig.left.K @ np.eye(3, 4)
        self._right = rig.right.K @ to_right.matrix()[:3]
        self._F = rig.fundamental().T  # OpenCV's order

    def points(self, left: Array, right: Array) -> Array:
        """Linear triangulation of (n, 2) pixels: (n, 3) mm."""
        homogeneous = cv2.triangulatePoints(self._left, self._right, left.T, right.T)
        return (homogeneous[:3] / homogeneous[3]).T

    def corrected_points(self, left: Array, right: Array) -> Array:
        """Triangulate the nearest exact correspondences: (n, 3) mm."""
        moved: Any = cv2.correctMatches(self._F, left[None], right[None])
        return self.points(moved[0][0], moved[1][0])


def main() -> None:
    """Measure and print."""
    quick = parser(__doc__).parse_args().quick
    count, optimal_count, repeats = (500, 20, 1) if quick else (100_000, 1_000, 7)
    cv2.setNumThreads(1)
    rig, points, left, right = tip_pairs(count)
    opencv = OpenCV(rig)
    exact = rig.project(points)
    some = slice(0, optimal_count)
    opencv_each_s = each_s(lambda: opencv.points(left[:1], right[:1]), repeats)
    opencv_s = best_s(lambda: opencv.points(left, right), repeats) / count
    corrected_s = best_s(lambda: opencv.corrected_points(left, right), repeats) / count
    methods: dict[str, dict[str, float]] = {}
    for method in METHODS:
        part = some if method == "optimal" else slice(None)
        a, b = left[part], right[part]
        bulk_s = best_s(lambda a=a, b=b, m=method: triangulate_points(a, b, rig, m), repeats)
        bulk_s /= len(a)
        single_s = each_s(lambda m=method: triangulate(left[0], right[0], rig, m), repeats)
        off = triangulate_points(exact[0][some], exact[1][some], rig, method) - points[some]
        methods[method] = {
            "bulk_pairs_per_s": 1 / bulk_s,
            "bulk_ratio_to_opencv": bulk_s / opencv_s,
            "single_pairs_per_s": 1 / single_s,
            "single_ratio_to_opencv": single_s / opencv_each_s,
            "largest_error_noise_free_mm": float(np.abs(off).max()),
        }
    methods["optimal"]["bulk_ratio_to_correct_matches"] = (
        1 / methods["optimal"]["bulk_pairs_per_s"] / corrected_s
    )
    report(
        "triangulate",
        quick=quick,
        pairs=count,
        pairs_optimal=optimal_count,
        repeats=repeats,
        opencv_bulk_pairs_per_s=1 / opencv_s,
        opencv_single_pairs_per_s=1 / opencv_each_s,
        opencv_correct_matches_pairs_per_s=1 / corrected_s,
        methods=methods,
    )


if __name__ == "__main__":
    main()
