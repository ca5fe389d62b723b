"""How long the detectors take on a pair, against the paper's steps one by one on whole images.

One thread, on the rendered colour pair of the paper's scene. The measure, `ratio_to_plain_steps`,
is against the tests' composition of the paper's steps (`tests/oracles/lin2020_oracle.py`), which
gives the same answer to the bit. `ratio_to_bare_opencv` is against the least number of OpenCV calls
on the whole image: no checks, no rounding rule for gray, no reasons, no needle axis.
`subpixel_over_plain_steps` is the time of `subpixel` over that of the plain steps, for a cone, and
for a bevel whose apex is seen from the side.

    python benchmarks/bench_detect.py [--quick]
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import cv2
import numpy as np
from environment import best_s, parser, report
from plain_lin2020 import plain_steps
from setting import paper_scene, with_samples

from simtip import SceneSpec, configure, simulate
from simtip.detect.components import needle_axis
from simtip.detect.gray import to_gray
from simtip.detect.lin2020_parameters import DEFAULTS
from simtip.detect.lin2020_steps import (
    binarise,
    edges,
    lowest_edge_pixel,
    median_filter,
    remove_small_components,
)
from simtip.spec import NeedleSpec

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


def bevel(scene: SceneSpec) -> SceneSpec:
    """Give the scene with a bevelled needle."""
    needle = scene.model_dump(mode="json")["needle"] | {"tip": {"kind": "bevel", "angle_deg": 20}}
    return scene.model_copy(update={"needle": NeedleSpec.model_validate(needle)})


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
        if seen.tip_px is None or not np.array_equal(seen.tip_px, plain_steps(image).tip_px):
            raise SystemExit("the two do not agree: their times mean nothing")
    pair_s = best_s(lambda: (detect(left), detect(right)), repeats)
    plain_s = best_s(lambda: (plain_steps(left), plain_steps(right)), repeats)
    bare_s = best_s(lambda: (bare_opencv(left), bare_opencv(right)), repeats)
    steps_s = {name: best_s(step, repeats) for name, step in steps_of(left).items()}
    total_s = sum(steps_s.values())
    subpixel = configure("subpixel")
    bevelled = simulate(bevel(scene)).images
    pairs = {"cone": (left, right), "bevel": [np.ascontiguousarray(image) for image in bevelled]}
    subpixel_s = {
        name: best_s(lambda pair=pair: [subpixel(image) for image in pair], repeats)
        for name, pair in pairs.items()
    }
    report(
        "detect",
        quick=quick,
        threads=cv2.getNumThreads(),
        size_px=[left.shape[1], left.shape[0]],
        repeats=repeats,
        pair_s=pair_s,
        plain_steps_pair_s=plain_s,
        ratio_to_plain_steps=plain_s / pair_s,
        subpixel_pair_s=subpixel_s,
        subpixel_over_plain_steps={name: t / plain_s for name, t in subpixel_s.items()},
        with_layers_pair_s=best_s(
            lambda: (detect(left, layers=True), detect(right, layers=True)), repeats
        ),
        bare_opencv_pair_s=bare_s,
        ratio_to_bare_opencv=pair_s / bare_s,
        whole_image_steps_s=steps_s,
        share_of_steps={name: t / total_s for name, t in steps_s.items()},
    )


if __name__ == "__main__":
    main()
