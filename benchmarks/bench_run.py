"""How long the whole of `simtip run` takes as a process, and how much of that is rendering.

The job is the paper's scene, with pictures and results written to a folder. Cold: with empty
caches, so that all kernels are compiled (the operating system's file cache is left alone). Warm:
again with the same caches. "Rendering" is the job's own figure, which includes loading Mitsuba.

    python benchmarks/bench_run.py [--quick]
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from environment import parser, report
from setting import SCENE, paper_scene

from simtip import dump_scene


def run(scene: Path, out: Path, caches: Path) -> dict[str, Any]:
    """Run the job in a process of its own; give its wall time and what it says of its stages."""
    places = {name: str(caches / name.lower()) for name in ("DRJIT_CACHE_DIR", "XDG_CACHE_HOME")}
    for place in places.values():
        Path(place).mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "simtip", "run", str(scene), "-o", str(out), "--json"]
    start = time.perf_counter()
    done = subprocess.run(
        command, env={**os.environ, **places}, check=True, stdout=subprocess.PIPE, text=True
    )
    wall_s = time.perf_counter() - start
    result = json.loads(done.stdout)
    return {
        "wall_s": wall_s,
        "status": result["status"],
        "backend": result["backend"],
        "stages_s": result["timings_s"],
        "share_of_rendering": result["timings_s"]["render"] / wall_s,
    }


def start_s() -> float:
    """Time a process that does nothing but start and say its version."""
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "simtip", "--version"], check=True, stdout=subprocess.DEVNULL
    )
    return time.perf_counter() - start


def main() -> None:
    """Measure and print."""
    quick = parser(__doc__).parse_args().quick
    repeats = 1 if quick else 3
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = SCENE
        if quick:
            scene = folder / "scene.yaml"
            scene.write_text(dump_scene(paper_scene(quick=True)), encoding="utf-8")
        cold = run(scene, folder / "cold", folder / "caches")
        warm = [run(scene, folder / f"warm{k}", folder / "caches") for k in range(repeats)]
    best = min(warm, key=lambda one: one["wall_s"])
    report(
        "run",
        quick=quick,
        repeats=repeats,
        version_only_s=min(start_s() for _ in range(repeats)),
        cold=cold,
        warm=best,
        ratio_cold_to_warm=cold["wall_s"] / best["wall_s"],
    )


if __name__ == "__main__":
    main()
