"""Many poses in one process: no memory is lost, and no kernel is compiled twice.

Every pose loads its scene anew: that takes under 3 % of the smallest render, and 2000 loads in a
row neither grew nor crashed. So what a sweep has to fear is kept memory, and kernels that change
with the pose: a shape's number or an array's alignment compiled into them is enough.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
POSES = 120
SETTLED = 30
"""Poses after which memory is to have found its level; every so many its kept part is read."""
GROWTH = 1.011
"""Of kept memory: in 90 poses, 7 pages each. Seen: 0.05 % from one reading to the next, and from
the 10th pose to the 30th, while the largest arrays come, 0.5 %."""

PRELUDE = """
import json, sys
import numpy as np
from regions import with_roi
from simtip.noise_budget import noise_tolerance
from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.scene_file import load_scene
from simtip.spec import SceneSpec

ROIS = [780, 800, 80, 100], [990, 795, 80, 100]
rng = np.random.default_rng(0)

def poses(name, count, **render):
    scene = with_roi(load_scene(f"scenes/{name}.yaml"), *ROIS, **render)
    for _ in range(count):
        data = scene.model_dump(mode="json")
        moved = np.array(data["needle"]["tip_mm"]) + rng.uniform(-2, 2, 3)
        data["needle"]["tip_mm"] = moved.tolist()
        yield SceneSpec.model_validate(data)
"""

MEMORY = """
import ctypes, gc
with activated(choose()):  # Dr.Jit alone would take any LLVM that it finds
    import drjit as dr
dr.set_thread_count(1)  # more would mostly wait

def resident_pages():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1])

def kept_pages():
    gc.collect()
    dr.sync_thread()
    dr.flush_malloc_cache()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # glibc's
    if trim is not None:
        trim(0)
    return resident_pages()

found = []
settled = int(sys.argv[2])
for k, scene in enumerate(poses("01_single_tip", int(sys.argv[1]), noise=None, samples=16,
                                light_step_mm=2.0)):
    render_pair(scene, seed=k)
    found.append([resident_pages(), kept_pages() if k % settled == settled - 1 else None])
print(json.dumps(found))
"""

KERNELS = """
with activated(choose()):
    import drjit as dr
dr.set_thread_count(1)
dr.set_flag(dr.JitFlag.KernelHistory, True)
found = []
for scene in poses(sys.argv[1], 5, samples=64, light_step_mm=2.0):
    render_pair(scene, tolerance=noise_tolerance(scene))
    kernels = [e for e in dr.kernel_history() if e["type"] == dr.KernelType.JIT]
    dr.kernel_history_clear()
    found.append([len(kernels), sum(not e["cache_hit"] for e in kernels)])
print(json.dumps(found))
"""


def run(script, *arguments, caches):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", PRELUDE + script, *arguments],
        check=False,
        capture_output=True,
        text=True,
        timeout=600,
        cwd=ROOT,
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT / "tests"),
            "DRJIT_CACHE_DIR": str(caches),
            "XDG_CACHE_HOME": str(caches),
            # Else how many heaps there are, and how full, is a matter of the threads' timing.
            "MALLOC_ARENA_MAX": "2",
        },
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_memory_after_120_poses_is_that_after_30(tmp_path):
    """Kept memory; what Dr.Jit holds of freed arrays varies with its threads by an array or two."""
    resident, kept = zip(*run(MEMORY, str(POSES), str(SETTLED), caches=tmp_path), strict=True)
    assert len(resident) == POSES
    settled, *later = [pages for pages in kept if pages is not None]
    assert max(later) <= GROWTH * settled
    assert max(resident[SETTLED:]) <= 1.15 * resident[SETTLED - 1]


@pytest.mark.parametrize(
    "name", ["01_single_tip", "02_real_camera", "07_paper_and_dust", "08_hostile"]
)
def test_no_kernel_is_compiled_after_the_first_pose(name, tmp_path):
    first, *later = run(KERNELS, name, caches=tmp_path)
    assert first[1] > 0  # with empty caches
    for kernels, compiled in later:
        assert kernels > 10
        assert compiled == 0
