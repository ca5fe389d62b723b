"""What a view without noise costs: simtip against Mitsuba's `path`, at equal noise, in one run.

The left view of the paper's scene, full size, kernels warm; the right camera reads out next to
nothing. simtip is asked for a noise of 0.5 % on the background and 1 % on the needle; what counts
is the CPU time that this took and the noise that several seeds really show. `path` is timed on
whole frames at two sample counts, time being a + b n; its noise is measured on a part of the view
at many samples, and goes with 1/sqrt(n).

Noise is a pixel's standard deviation over seeds (mean of r, g, b) over its mean, root mean square
over the region. The flank is where the needle covers the whole pixel; the background is what lies
5 px or more away from the needle.

    python benchmarks/bench_render.py [--quick] [--json] [--pictures DIR] [--backend NAME]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any
from unittest import mock

import cv2
import numpy as np
from environment import Spent, parser, report, spent
from numpy.typing import NDArray
from setting import left_only, paper_scene, with_render

from simtip import Camera, Pose, SceneSpec, render_pair
from simtip.noise_budget import noise_tolerance
from simtip.render import Tolerance
from simtip.render.backend import Backend, activated, choose

TARGET = {"background": 0.005, "flank": 0.01}
BRIGHT = 0.8
"""As bright as this, over the background's light, is asked to be as free of noise as that."""
SHAFT_MM = 25.0
"""The part of the view where `path`'s noise is measured is centred this far up from the tip."""
ROOM_WEIGHT = 0.02
"""For `path` with the choice of emitters helped: about the best of 1, 0.1, 0.05, 0.02, 0.01."""
MOST_SAMPLES = 16384

Floats = NDArray[np.float32]
Mask = NDArray[np.bool_]
Window = tuple[int, int, int, int]


@dataclass(frozen=True)
class Size:
    """How much the benchmark does."""

    seeds: int
    pair_repeats: int
    most_samples: int
    """That simtip may spend on a pixel."""
    path_seeds: int
    path_samples: tuple[int, int]
    """To time `path`."""
    path_samples_noise: int
    sampler_samples: int
    """To find `path`'s best sampler."""
    part_px: int


FULL = Size(6, 3, MOST_SAMPLES, 4, (4, 16), 1024, 256, 160)
QUICK = Size(2, 1, 256, 2, (4, 16), 64, 16, 60)


def asked(radiance: Floats, background: Floats | None) -> Floats:
    """Allow a pixel the target's noise: a `Tolerance`."""
    gray = radiance.mean(axis=-1)
    bright = gray > BRIGHT * (np.inf if background is None else background.mean())
    relative = np.where(bright, TARGET["background"], TARGET["flank"])
    allowed: Floats = (relative * gray).astype(np.float32)
    return allowed


def noise_map(images: Floats) -> Floats:
    """Give each pixel's standard deviation over seeds, over its mean, (H, W)."""
    values = images.astype(np.float64)
    relative: Floats = (values.std(axis=0, ddof=1) / values.mean(axis=0)).astype(np.float32)
    return relative


def noise(images: Floats, where: Mask) -> float:
    """Give the root mean square of the noise map in a region."""
    return float(np.sqrt(np.mean(noise_map(images)[where].astype(np.float64) ** 2)))


@dataclass(frozen=True, eq=False)
class Pictures:
    """The left view of several seeds, and what one took."""

    gray: Floats
    """(seeds, H, W) radiance."""
    claimed: float
    """Noise of the flank by the renderer's own account."""
    cost: Spent
    traced: int
    """Samples traced for one."""
    flank: Mask
    background: Mask


def render_simtip(scene: SceneSpec, tolerance: Tolerance, backend: Backend, seeds: int) -> Pictures:
    """Render with several seeds and keep the left views."""
    from simtip.mix import weights
    from simtip.render.progress import Tally

    traced = 0

    class Counting(Tally):
        def add(self, samples: int) -> None:
            nonlocal traced
            traced += samples
            super().add(samples)

    views = []

    def once(seed: int) -> None:
        views.append(render_pair(scene, backend=backend, seed=seed, tolerance=tolerance)[0])

    with activated(backend), mock.patch("simtip.render.pair.Tally", Counting):
        costs = [spent(lambda seed=seed: once(seed)) for seed in range(seeds)]
    gray = np.stack([view.radiance(scene).mean(axis=-1) for view in views])
    coverage = np.stack([view.coverage for view in views])
    near = cv2.dilate((coverage > 0).any(axis=0).astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    flank = (coverage == 1).all(axis=0)
    power = weights(scene, 1)
    sd = views[0].noise.sd([power[name].mean() for name in views[0].lamps])
    claimed = float(np.sqrt(np.mean((sd[flank] / gray[0][flank]) ** 2)))
    return Pictures(gray, claimed, reduce(Spent.best, costs), traced // seeds, flank, ~near)


@dataclass(frozen=True)
class Law:
    """CPU time a + b n of n samples per pixel."""

    a: float
    b: float

    @classmethod
    def through(cls, few: tuple[int, float], many: tuple[int, float]) -> Law:
        """Fit two measured counts and times."""
        b = max((many[1] - few[1]) / (many[0] - few[0]), 1e-9)
        return cls(max(few[1] - b * few[0], 0.0), b)

    def at(self, samples: float) -> float:
        """CPU time, s."""
        return self.a + self.b * samples

    def samples_in(self, cpu_s: float) -> int:
        """How many samples fit, at least one."""
        return max(1, int((cpu_s - self.a) / self.b))


def samples_needed(noises: dict[str, float], samples: int) -> dict[str, float]:
    """Scale a sample count to the target of each region: noise goes with 1/sqrt(samples)."""
    return {name: samples * (noises[name] / TARGET[name]) ** 2 for name in TARGET}


@dataclass(frozen=True, eq=False)
class Part:
    """Where `path`'s noise is measured: a cropped left camera, and its regions."""

    camera: Camera
    masks: dict[str, Mask]


def compare_samplers(scene: SceneSpec, size: Size, part: Part) -> dict[str, float]:
    """Give CPU time times squared noise on the flank of each sampler, over the best one's."""
    from stock_path import SAMPLERS, StockPath

    products = {}
    for sampler in SAMPLERS:
        stock = StockPath(scene, ROOM_WEIGHT, sampler)
        stock.render(part.camera, Pose.identity(), size.sampler_samples)  # kernels
        images: list[Floats] = []

        def once(seed: int, stock: Any = stock, images: list[Floats] = images) -> None:
            images.append(stock.render(part.camera, Pose.identity(), size.sampler_samples, seed))

        costs = [spent(lambda seed=seed: once(seed)) for seed in range(size.path_seeds)]
        cpu_s = reduce(Spent.best, costs).cpu_s
        products[sampler] = cpu_s * noise(np.stack(images), part.masks["flank"]) ** 2
    least = min(products.values())
    return {sampler: product / least for sampler, product in products.items()}


def measure_path(
    scene: SceneSpec, size: Size, part: Part, room: float, sampler: str
) -> tuple[dict[str, Any], Law]:
    """Time `path` on the whole left view, and take its noise on a part of it."""
    from stock_path import StockPath

    left = scene.rig.rig().left
    stock = StockPath(scene, room, sampler)

    def view(samples: int) -> Callable[[], object]:
        return lambda: stock.render(left, Pose.identity(), samples)

    few, many = size.path_samples
    costs = {}
    for samples in (few, many):
        view(samples)()  # kernels
        costs[samples] = spent(view(samples)).best(spent(view(samples)))
    law = Law.through((few, costs[few].cpu_s), (many, costs[many].cpu_s))
    samples = size.path_samples_noise
    gray = np.stack(
        [
            stock.render(part.camera, Pose.identity(), samples, seed)
            for seed in range(size.path_seeds)
        ]
    )
    noises = {name: noise(gray, where) for name, where in part.masks.items()}
    needed = samples_needed(noises, samples)
    figures = {
        "cpu_s": law.at(max(needed.values())),
        "cpu_s_background_alone": law.at(needed["background"]),
        "noise_samples": samples,
        "noise": noises,
        "samples_needed": needed,
        "timed_samples": [few, many],
        "timed_cpu_s": [costs[few].cpu_s, costs[many].cpu_s],
        "msamples_per_s": left.width * left.height * many / costs[many].wall_s / 1e6,
        "radiance": {name: float(gray[:, where].mean()) for name, where in part.masks.items()},
    }
    return figures, law


def part_of(scene: SceneSpec, side: int) -> Window:
    """Choose the part of the left view where noise is measured: x, y, width, height."""
    axis = np.array(scene.needle.axis)
    shaft = np.array(scene.needle.tip_mm) + SHAFT_MM * axis / np.linalg.norm(axis)
    u, v = scene.rig.left.camera().project(shaft)
    return round(u) - side // 2, round(v) - side // 2, side, side


def pair_cost(scene: SceneSpec, backend: Backend, repeats: int) -> Spent:
    """Time both views at the noise that the scene asks for, as `simtip run` does."""
    tolerance = noise_tolerance(scene)
    costs = [
        spent(lambda seed=seed: render_pair(scene, backend=backend, seed=seed, tolerance=tolerance))
        for seed in range(repeats)
    ]
    return reduce(Spent.best, costs)


def write_pictures(
    folder: Path, scene: SceneSpec, own: Pictures, samples: int, window: Window, sampler: str
) -> None:
    """Draw the noise of both in the CPU time that simtip took, on one scale."""
    from noise_maps import draw
    from stock_path import StockPath

    left = scene.rig.rig().left
    stock = StockPath(scene, ROOM_WEIGHT, sampler)
    gray = np.stack(
        [stock.render(left, Pose.identity(), samples, seed) for seed in range(len(own.gray))]
    )
    folder.mkdir(parents=True, exist_ok=True)
    maps = {
        f"simtip, {own.cost.cpu_s:.1f} s CPU": noise_map(own.gray),
        f"path, {samples} samples per pixel, as much CPU": noise_map(gray),
    }
    draw(folder / "noise_maps.png", maps, window, len(own.gray))


def main() -> None:
    """Measure and print."""
    arguments = parser(__doc__)
    arguments.add_argument("--backend", default="llvm", help="its CPU time is what counts")
    arguments.add_argument("--pictures", type=Path, metavar="DIR", help="write noise maps there")
    given = arguments.parse_args()
    size = QUICK if given.quick else FULL
    backend = choose(given.backend)
    whole = paper_scene(quick=given.quick)
    scene = with_render(left_only(whole), samples=size.most_samples)
    render_pair(scene, backend=backend, tolerance=asked)  # kernels
    own = render_simtip(scene, asked, backend, size.seeds)
    regions = {"background": own.background, "flank": own.flank}
    noises = {name: noise(own.gray, where) for name, where in regions.items()}
    # Were the noise not what was asked for, the time would be that of more samples.
    short = max(1.0, *(noises[name] / TARGET[name] for name in TARGET))
    cpu_s = own.cost.cpu_s * short**2

    x, y, w, h = window = part_of(scene, size.part_px)
    inside = (slice(y, y + h), slice(x, x + w))
    left = scene.rig.rig().left
    part = Part(left.cropped(*window), {name: where[inside] for name, where in regions.items()})
    with activated(backend):
        samplers = compare_samplers(scene, size, part)
        best = min(samplers, key=samplers.__getitem__)
        path, _ = measure_path(scene, size, part, 1.0, best)
        helped, law = measure_path(scene, size, part, ROOM_WEIGHT, best)
        if given.pictures is not None:
            samples = law.samples_in(own.cost.cpu_s)
            write_pictures(given.pictures, scene, own, samples, window, best)
    pair = pair_cost(whole, backend, size.pair_repeats)
    radiance = {
        name: float(own.gray[:, *inside][:, where].mean()) for name, where in part.masks.items()
    }
    report(
        "render",
        quick=given.quick,
        backend=backend.variant,
        size_px=[left.width, left.height],
        seeds=size.seeds,
        target_noise=TARGET,
        cpu_s_simtip=cpu_s,
        cpu_s_path=path["cpu_s"],
        ratio=path["cpu_s"] / cpu_s,
        ratio_to_room_weighted_path=helped["cpu_s"] / cpu_s,
        ratio_to_path_for_background_alone=path["cpu_s_background_alone"] / cpu_s,
        noise_background=noises["background"],
        noise_flank=noises["flank"],
        noise_flank_claimed=own.claimed,
        msamples_per_s=own.traced / own.cost.wall_s / 1e6,
        wall_s_simtip=own.cost.wall_s,
        traced_msamples=own.traced / 1e6,
        pair_at_scenes_noise={
            "noise": whole.render.noise,
            "wall_s": pair.wall_s,
            "cpu_s": pair.cpu_s,
        },
        radiance_simtip_to_path={
            name: radiance[name] / helped["radiance"][name] for name in radiance
        },
        part_of_left_view=list(window),
        path_sampler=best,
        path_samplers_cost_to_best=samplers,
        path={"default": path, "room_weighted": helped},
    )


if __name__ == "__main__":
    main()
