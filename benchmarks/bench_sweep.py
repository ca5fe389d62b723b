"""What a sweep costs over its stages alone, and what a second worker brings.

One pose, 4 powers, 5 exposures, 50 thresholds, `lin2020` and `subpixel`: 2000 trials of one
render, 20 pairs of images, 1000 different measurements by the one and 20 by the other, which has no
threshold. Alone: a plain script that calls those stages one after the other and keeps nothing, as a
process of its own, and what of it is spent in the stages. As a sweep: the whole of `simtip sweep`
as a process, its cache empty.

Then trials of new images, the light being there, each with fresh noise: bare calls in a loop, and
in a sweep, whose start is taken out by the difference of a short one and a long one (not quick).

    python benchmarks/bench_sweep.py [--quick]
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import yaml
from environment import parser, report
from setting import paper_scene

from simtip import SceneSpec, dump_scene
from simtip.detect import configure
from simtip.measure import measure_pair
from simtip.noise_budget import noise_tolerance
from simtip.render import choose, render_pair
from simtip.simulation import expose_pair

DETECTORS = ("lin2020", "subpixel")


def levels(*, quick: bool) -> dict[str, Any]:
    """Give the factors."""
    many = (2, 2, 4) if quick else (4, 5, 50)
    return {
        "lamps[0].power": {"from": 0.7, "to": 1.3, "count": many[0]},
        "sensor.exposure_s": {"from": 0.035, "to": 0.055, "count": many[1]},
        "detect.threshold": {"from": 70, "to": 70 + many[2] - 1, "count": many[2]},
    }


def spread(level: dict[str, Any]) -> list[float]:
    """Give a range's values."""
    step = (level["to"] - level["from"]) / (level["count"] - 1)
    return [level["from"] + k * step for k in range(level["count"])]


def lit(scene: SceneSpec, power: float, exposure_s: float) -> SceneSpec:
    """Give the scene with another power of its first lamp and another exposure."""
    data = scene.model_dump(mode="json", exclude_unset=True)
    data["lamps"][0]["power"] = power
    data["sensor"]["exposure_s"] = exposure_s
    return SceneSpec.model_validate(data)


def alone(scene: SceneSpec, factors: dict[str, Any]) -> dict[str, float]:
    """Time the stages: render once, expose and measure what is distinct."""
    backend = choose()
    powers, exposures, thresholds = (spread(level) for level in factors.values())
    # One light for all of them has to satisfy the one with least noise of its own.
    tolerance = noise_tolerance(lit(scene, powers[-1], exposures[-1]))
    start = time.perf_counter()
    views = render_pair(scene, backend=backend, seed=1, tolerance=tolerance)
    spent = {"render_s": time.perf_counter() - start, "images_s": 0.0, "measure_s": 0.0}
    rig = scene.rig.rig()
    for power in powers:
        for exposure_s in exposures:
            spec = lit(scene, power, exposure_s)
            start = time.perf_counter()
            images = expose_pair(spec, views, seed=1, backend=backend, light_seed=1).images
            exposed = time.perf_counter()
            for threshold in thresholds:
                measure_pair(*images, rig, configure("lin2020", {"threshold": int(threshold)}))
            measure_pair(*images, rig, configure("subpixel"))
            spent["images_s"] += exposed - start
            spent["measure_s"] += time.perf_counter() - exposed
    return spent


def timed(command: list[str]) -> tuple[float, Any]:
    """Run a command; give its wall time and the JSON that it prints."""
    start = time.perf_counter()
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return time.perf_counter() - start, json.loads(done.stdout)


def swept(folder: Path, name: str, workers: int, cache: str, file: str = "sweep") -> dict[str, Any]:
    """Run `simtip sweep` in a process of its own; give its wall time and what it worked out."""
    command = [
        *(sys.executable, "-m", "simtip", "sweep", str(folder / f"{file}.yaml"), "--json"),
        *("-o", str(folder / name), "--cache", str(folder / cache), "--workers", str(workers)),
    ]
    wall_s, said = timed(command)
    return {"wall_s": wall_s, "trials": said["trials"], "worked_out": said["worked_out"]}


def fresh_per_s(folder: Path, workers: int, repeats: tuple[int, int]) -> float:
    """Give the trials a second of new images, the light being in the cache."""
    took = []
    for count in (1, *repeats):  # the first one sees to the light
        name = f"fresh-{workers}-{count}"
        said = {"scene": "scene.yaml", "repeats": count, "seed": 100 * workers + count}
        (folder / f"{name}.yaml").write_text(yaml.safe_dump({**said, "detectors": ["lin2020"]}))
        took.append(swept(folder, name, workers, "cache-fresh", name)["wall_s"])
    return (repeats[1] - repeats[0]) / (took[2] - took[1])


def bare_per_s(scene: SceneSpec, repeats: int) -> float:
    """Give the same, worked out by bare calls."""
    backend, detector, rig = choose(), configure("lin2020"), scene.rig.rig()
    views = render_pair(scene, backend=backend, seed=1, tolerance=noise_tolerance(scene))
    start = time.perf_counter()
    for seed in range(repeats):
        shot = expose_pair(scene, views, seed=seed, backend=backend, light_seed=1)
        measure_pair(*shot.images, rig, detector)
    return repeats / (time.perf_counter() - start)


def rates(folder: Path, scene: SceneSpec) -> dict[str, Any]:
    """Compare trials a second of new images: bare calls, one worker, two."""
    bare = bare_per_s(scene, 10)
    one, two = (fresh_per_s(folder, workers, (10, 60)) for workers in (1, 2))
    return {
        "new_images_per_s": {"bare": bare, "one_worker": one, "two_workers": two},
        "ratio_one_worker_to_bare": one / bare,
        "ratio_two_workers_to_one": two / one,
    }


def main() -> None:
    """Measure and print."""
    asked = parser(__doc__)
    asked.add_argument("--alone", action="store_true", help="only the plain script's times")
    given = asked.parse_args()
    quick = given.quick
    scene, factors = paper_scene(quick=quick), levels(quick=quick)
    if given.alone:
        print(json.dumps(alone(scene, factors)))
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "scene.yaml").write_text(dump_scene(scene))
        said = {"scene": "scene.yaml", "factors": factors, "detectors": list(DETECTORS)}
        (folder / "sweep.yaml").write_text(yaml.safe_dump(said))
        plain = [sys.executable, __file__, "--alone", *(["--quick"] if quick else [])]
        plain_s, stages = timed(plain)
        one = swept(folder, "one", 1, "cache-one")
        two = swept(folder, "two", 2, "cache-two")
        fresh = {} if quick else rates(folder, scene)
    report(
        "sweep",
        quick=quick,
        plain_script={"wall_s": plain_s, **stages},
        one_worker=one,
        two_workers=two,
        ratio_to_plain_script=one["wall_s"] / plain_s,
        ratio_to_stages_alone=one["wall_s"] / sum(stages.values()),
        ratio_one_to_two_workers=one["wall_s"] / two["wall_s"],
        **fresh,
    )


if __name__ == "__main__":
    main()
