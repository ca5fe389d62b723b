"""How long lin2020 takes on an image, step by step, against bare OpenCV calls for the same steps.

One thread, on the rendered left image of the paper's scene; the pair is timed as well. The bare
calls are the least that the paper's sequence costs: no checks, no rounding rule for gray, no
reasons, no needle axis.

    python benchmarks/bench_detect.py [--quick]
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import cv2
import numpy as np
from environment import best_s, parser, report
from setting import paper_scene, with_samples

from simtip import configure, simulate
from simtip.detect.lin2020 import (
    DEFAULTS,
    binarise,
    edges,
    lowest_edge_pixel,
    median_filter,
    needle_axis,
    remove_small_components,
    to_gray,
)

SAMPLES = 16
"""Enough for a realistic picture: the sensor's noise covers the renderer's."""


def steps_of(image: Any) -> dict[str, Callable[[], object]]:
    """Give each step, ready to run on what the step before it makes of the image."""
    gray = to_gray(image)
    filtered = median_filter(gray)
    binary = binarise(filtered)
    cleaned = remove_small_components(binary)
    edge = edges(cleaned)
    tip = lowest_edge_pixel(edge)
    if tip is None:
        raise SystemExit("the benchmark's own image has no needle in it")
    return {
        "to_gray": partial(to_gray, image),
        "median_filter": partial(median_filter, gray),
        "binarise": partial(binarise, filtered),
        "remove_small_components": partial(remove_small_components, binary),
        "edges": partial(edges, cleaned),
        "lowest_edge_pixel": partial(lowest_edge_pixel, edge),
        "needle_axis": partial(needle_axis, cleaned, tip),
    }


def bare_opencv(image: Any) -> None:
    """Do the paper's sequence in as few calls as possible."""
    p = DEFAULTS
    gray = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    filtered = cv2.medianBlur(gray, p.median_window)
    _, dark = cv2.threshold(filtered, p.threshold - 1, 255, cv2.THRESH_BINARY_INV)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(dark, connectivity=p.connectivity)
    small = stats[:, cv2.CC_STAT_AREA] < p.min_area_px
    dark[small[labels]] = 0
    edge = cv2.Canny(dark, p.canny_low, p.canny_high)
    cv2.findNonZero(edge).reshape(-1, 2)[:, 1].argmax()


def main() -> None:
    """Measure and print."""
    quick = parser(__doc__).parse_args().quick
    repeats = 1 if quick else 15
    cv2.setNumThreads(1)
    scene = with_samples(paper_scene(quick=quick), SAMPLES)
    left, right = (np.ascontiguousarray(image) for image in simulate(scene).images)
    detect = configure("lin2020")
    for image in (left, right):
        if (seen := detect(image)).reason:
            raise SystemExit(f"the benchmark's own image: {seen.reason}")
    steps_s = {name: best_s(step, repeats) for name, step in steps_of(left).items()}
    detect_s = best_s(lambda: detect(left), repeats)
    bare_s = best_s(lambda: bare_opencv(left), repeats)
    total_s = sum(steps_s.values())
    report(
        "detect",
        quick=quick,
        threads=cv2.getNumThreads(),
        size_px=[left.shape[1], left.shape[0]],
        repeats=repeats,
        detect_s=detect_s,
        pair_s=best_s(lambda: (detect(left), detect(right)), repeats),
        steps_s=steps_s,
        share_of_steps={name: t / total_s for name, t in steps_s.items()},
        bare_opencv_s=bare_s,
        ratio_to_bare_opencv=detect_s / bare_s,
    )


if __name__ == "__main__":
    main()
