"""What another mix of the lamps costs, against rendering: a full-size pair with four lamps.

The pair is rendered as `simtip run` would, to the noise that the scene asks for. Then all lamps get
another power and both views are mixed anew: for a global shutter, for a rolling shutter before
flickering lamps, and from light files on disk. CPU time of all threads, at the best of several.

    python benchmarks/bench_mix.py [--quick]
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
from environment import Spent, parser, report, spent
from setting import four_lamps, paper_scene

from simtip import SceneSpec, render_pair
from simtip.light_file import Lights, lights_name, write_lights
from simtip.noise_budget import noise_tolerance
from simtip.remix import read_pair
from simtip.render import View, choose

POWER = (0.5, 2.0, 0.0, 1.3)


def dimmed(scene: SceneSpec) -> SceneSpec:
    """Give the scene with other lamp powers, one lamp off."""
    lamps = [
        lamp.model_copy(update={"power": lamp.power * factor})
        for lamp, factor in zip(scene.lamps, POWER, strict=True)
    ]
    return scene.model_copy(update={"lamps": tuple(lamps)})


def best(work: Callable[[], object], repeats: int) -> Spent:
    """Run something several times and keep the least of both times."""
    return reduce(Spent.best, [spent(work) for _ in range(repeats)])


def from_files(
    views: tuple[View, View], scene: SceneSpec, other: SceneSpec, repeats: int
) -> dict[str, Any]:
    """Write both views, and time a mix that starts by reading them whole, noise and all."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        paths = {side: folder / lights_name(side) for side in ("left", "right")}

        def write() -> None:
            for (side, path), view in zip(paths.items(), views, strict=True):
                write_lights(path, Lights(view, scene, scene.seed, side))

        def mix() -> None:
            for lights in read_pair(folder):
                lights.view.radiance(other)

        written, mixed = best(write, 1), best(mix, repeats)
        read = best(lambda: read_pair(folder), repeats)
        size = sum(path.stat().st_size for path in paths.values())
    return {
        "write_cpu_s": written.cpu_s,
        "read_cpu_s": read.cpu_s,
        "mix_cpu_s": mixed.cpu_s,
        "mix_wall_s": mixed.wall_s,
        "size_mb": size / 1e6,
    }


def main() -> None:
    """Measure and print."""
    quick = parser(__doc__).parse_args().quick
    renders, repeats = (1, 1) if quick else (3, 7)
    backend = choose()
    scene = four_lamps(paper_scene(quick=quick), rolling=False)
    tolerance = noise_tolerance(scene)
    views: list[tuple[View, View]] = [render_pair(scene, backend=backend, tolerance=tolerance)]

    def render() -> None:
        views[0] = render_pair(scene, backend=backend, tolerance=tolerance)

    rendered = best(render, renders)
    pair = views[0]
    mixes = {}
    for shutter, rolling in (("global", False), ("rolling", True)):
        other = dimmed(four_lamps(scene, rolling=rolling))
        mixes[shutter] = best(lambda s=other: [view.radiance(s) for view in pair], repeats)
    files = from_files(pair, scene, dimmed(scene), repeats)
    rows = dimmed(four_lamps(scene, rolling=True))
    height = pair[0].response.shape[1]
    report(
        "mix",
        quick=quick,
        backend=backend.variant,
        size_px=[pair[0].response.shape[2], height],
        groups=len(pair[0].lamps),
        render_cpu_s=rendered.cpu_s,
        render_wall_s=rendered.wall_s,
        mix_cpu_s={name: cost.cpu_s for name, cost in mixes.items()},
        mix_wall_s={name: cost.wall_s for name, cost in mixes.items()},
        ratio_to_rendering={name: cost.cpu_s / rendered.cpu_s for name, cost in mixes.items()},
        files=files,
        ratio_from_files_to_rendering=files["mix_cpu_s"] / rendered.cpu_s,
        rows_differ_by_up_to=_ripple(pair[0], rows),
    )


def _ripple(view: View, scene: SceneSpec) -> float:
    """Give the spread of a rolling shutter's rows, largest over smallest: that it really ran."""
    rows = np.median(view.radiance(scene).mean(axis=-1), axis=1)
    steady = np.median(
        view.radiance(dimmed(four_lamps(scene, rolling=False))).mean(axis=-1), axis=1
    )
    ratio = rows / steady
    return float(ratio.max() / ratio.min() - 1)


if __name__ == "__main__":
    main()
