"""What a rendered pair costs, how noisy it is, and what Mitsuba's `path` would need for the same.

Both views of the paper's scene at full size, kernels warm. The CPU time for a stated noise comes
from two sample counts: time is a + b n, and noise goes with 1/sqrt(n) from the larger count on,
which is chosen close to what is needed. `path` is timed on whole frames, and its noise is measured
on a part of the left view at many samples; simtip's noise is compared on the same part.

Noise is the standard deviation of a pixel's radiance (mean of r, g, b) over seeds: the root of its
mean square over the region, over the region's mean radiance. The flank is where the needle covers
the whole pixel; the background is what lies 5 px or more away from the needle.

    python benchmarks/bench_render.py [--quick] [--backend NAME]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any
from unittest import mock

import cv2
import numpy as np
from environment import Spent, parser, report, spent
from numpy.typing import NDArray
from setting import paper_scene, with_samples

from simtip import Pose, SceneSpec, render_pair
from simtip.render.backend import Backend, activated, choose

TARGET = {"background": 0.005, "flank": 0.01}
SHAFT_MM = 25.0
"""The part of the view where noise is compared is centred this far up from the tip."""
ROOM_WEIGHT = 0.02
"""For `path` with the choice of emitters helped: about the best of 1, 0.1, 0.05, 0.02, 0.01."""

Floats = NDArray[np.float32]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Size:
    """How much the benchmark does."""

    seeds: int
    samples_high: int
    """simtip's larger count; the smaller is the scene's own."""
    path_samples: tuple[int, int]
    """To time `path`."""
    path_samples_noise: int
    part_px: int


FULL = Size(3, 576, (4, 16), 1024, 160)
QUICK = Size(2, 64, (4, 16), 64, 60)


@dataclass(frozen=True, eq=False)
class Pictures:
    """The left view of several seeds, and what one pair took."""

    gray: Floats
    """(seeds, H, W) radiance."""
    cost: Spent
    traced: int
    """Samples traced for a pair."""
    flank: Mask
    background: Mask


def noise(images: Floats, where: Mask) -> float:
    """Give the standard deviation over seeds, relative to the mean, in a region."""
    values = images[:, where].astype(np.float64)
    return float(np.sqrt(values.var(axis=0, ddof=1).mean()) / values.mean())


def render_simtip(scene: SceneSpec, backend: Backend, seeds: int) -> Pictures:
    """Render pairs with several seeds and keep the left views."""
    from simtip.render.progress import Tally

    traced = 0

    class Counting(Tally):
        def add(self, samples: int) -> None:
            nonlocal traced
            traced += samples
            super().add(samples)

    grays, coverages = [], []

    def once(seed: int) -> None:
        left, _ = render_pair(scene, backend=backend, seed=seed)
        grays.append(left.radiance(scene).mean(axis=-1))
        coverages.append(left.coverage)

    with activated(backend), mock.patch("simtip.render.pair.Tally", Counting):
        costs = [spent(lambda seed=seed: once(seed)) for seed in range(seeds)]
    coverage = np.stack(coverages)
    near = cv2.dilate((coverage > 0).any(axis=0).astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    flank = (coverage > 0.999).all(axis=0)
    return Pictures(np.stack(grays), reduce(Spent.best, costs), traced // seeds, flank, ~near)


@dataclass(frozen=True)
class Law:
    """CPU time a + b n of n samples per pixel."""

    a: float
    b: float

    @classmethod
    def through(cls, few: tuple[int, float], many: tuple[int, float]) -> Law:
        """Fit two measured counts and times."""
        b = max((many[1] - few[1]) / (many[0] - few[0]), 0.0)
        return cls(max(few[1] - b * few[0], 0.0), b)

    def at(self, samples: float) -> float:
        """CPU time, s."""
        return self.a + self.b * samples


def samples_needed(noises: dict[str, float], samples: int) -> dict[str, float]:
    """Scale a sample count to the target of each region: noise goes with 1/sqrt(samples)."""
    return {name: samples * (noises[name] / TARGET[name]) ** 2 for name in TARGET}


def measure_path(
    scene: SceneSpec,
    size: Size,
    part: tuple[int, int, int, int],
    masks: dict[str, Mask],
    room: float,
) -> dict[str, Any]:
    """Time `path` on both whole frames, and take its noise on a part of the left one."""
    from stock_path import StockPath

    rig = scene.rig.rig()
    stock = StockPath(scene, room)

    def pair(samples: int) -> Callable[[], None]:
        def work() -> None:
            stock.render(rig.left, Pose.identity(), samples)
            stock.render(rig.right, rig.T_lr, samples)

        return work

    few, many = size.path_samples
    costs = {}
    for samples in (few, many):
        pair(samples)()  # kernels
        costs[samples] = spent(pair(samples)).best(spent(pair(samples)))
    camera, samples = rig.left.cropped(*part), size.path_samples_noise
    images = [stock.render(camera, Pose.identity(), samples, seed) for seed in range(size.seeds)]
    gray = np.stack(images)
    noises = {name: noise(gray, where) for name, where in masks.items()}
    needed = samples_needed(noises, samples)
    law = Law.through((few, costs[few].cpu_s), (many, costs[many].cpu_s))
    pixels = sum(camera.width * camera.height for camera in (rig.left, rig.right))
    return {
        "cpu_s": law.at(max(needed.values())),
        "cpu_s_background_alone": law.at(needed["background"]),
        "noise_samples": samples,
        "noise": noises,
        "samples_needed": needed,
        "timed_samples": [few, many],
        "timed_cpu_s": [costs[few].cpu_s, costs[many].cpu_s],
        "msamples_per_s": pixels * many / costs[many].wall_s / 1e6,
        "radiance": {name: float(gray[:, where].mean()) for name, where in masks.items()},
    }


def part_of(scene: SceneSpec, side: int) -> tuple[int, int, int, int]:
    """Choose the part of the left view where noise is compared: x, y, width, height."""
    axis = np.array(scene.needle.axis)
    shaft = np.array(scene.needle.tip_mm) + SHAFT_MM * axis / np.linalg.norm(axis)
    u, v = scene.rig.left.camera().project(shaft)
    return round(u) - side // 2, round(v) - side // 2, side, side


def main() -> None:
    """Measure and print."""
    arguments = parser(__doc__)
    arguments.add_argument("--backend", default="llvm", help="its CPU time is what counts")
    given = arguments.parse_args()
    size = QUICK if given.quick else FULL
    backend = choose(given.backend)
    scene = paper_scene(quick=given.quick)
    low, high = scene.render.samples, size.samples_high
    render_pair(scene, backend=backend)  # kernels
    own = render_simtip(scene, backend, size.seeds)
    more = render_simtip(with_samples(scene, high), backend, size.seeds)

    x, y, w, h = part = part_of(scene, size.part_px)
    window = (slice(y, y + h), slice(x, x + w))
    masks = {"background": more.background[window], "flank": more.flank[window]}
    gray = more.gray[:, *window]
    noises = {name: noise(gray, where) for name, where in masks.items()}
    needed = samples_needed(noises, high)
    law = Law.through((low, own.cost.cpu_s), (high, more.cost.cpu_s))
    # The background's light has a cost of its own, which does not depend on the samples per pixel.
    fixed = law.a * max(1.0, (noises["background"] / TARGET["background"]) ** 2)
    cpu_s = fixed + law.b * needed["flank"]

    with activated(backend):
        paths = {
            name: measure_path(scene, size, part, masks, weight)
            for name, weight in (("default", 1.0), ("room_weighted", ROOM_WEIGHT))
        }
    radiance = {name: float(gray[:, where].mean()) for name, where in masks.items()}
    report(
        "render",
        quick=given.quick,
        backend=backend.variant,
        size_px=[more.gray.shape[2], more.gray.shape[1]],
        seeds=size.seeds,
        samples=low,
        pair_wall_s=own.cost.wall_s,
        pair_cpu_s=own.cost.cpu_s,
        noise_background=noise(own.gray, own.background),
        noise_flank=noise(own.gray, own.flank),
        msamples_per_s=more.traced / more.cost.wall_s / 1e6,
        target_noise=TARGET,
        cpu_s_simtip=cpu_s,
        cpu_s_path=paths["default"]["cpu_s"],
        ratio=paths["default"]["cpu_s"] / cpu_s,
        ratio_to_room_weighted_path=paths["room_weighted"]["cpu_s"] / cpu_s,
        ratio_to_path_for_background_alone=paths["default"]["cpu_s_background_alone"] / cpu_s,
        radiance_simtip_to_path={
            name: radiance[name] / paths["room_weighted"]["radiance"][name] for name in radiance
        },
        part_of_left_view=list(part),
        simtip={
            "noise_samples": high,
            "noise": noises,
            "samples_needed": needed,
            "timed_samples": [low, high],
            "timed_cpu_s": [own.cost.cpu_s, more.cost.cpu_s],
            "traced_msamples": [own.traced / 1e6, more.traced / 1e6],
        },
        path=paths,
    )


if __name__ == "__main__":
    main()
