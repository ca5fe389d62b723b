"""Does a long sweep's memory stay flat? Of its coordinator and its workers, sampled while it runs.

    python benchmarks/sweep_memory.py [--trials 5000] [--workers 2]

Trials of two small regions around the tip, two thresholds of every pair of images. Prints JSON:
for each process the resident memory when a tenth of the trials were done, at the end, and the
largest ratio of any later sample to that; Linux only.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

from simtip.sweep.table import Table

ROOT = Path(__file__).resolve().parents[1]
EVERY_S = 1.0


def sweep_file(folder: Path, trials: int) -> Path:
    """Write a sweep of so many trials of a small scene."""
    data = yaml.safe_load((ROOT / "scenes" / "01_single_tip.yaml").read_text())
    data["rig"]["left"]["roi"] = [770, 760, 100, 150]
    data["rig"]["right"]["roi"] = [983, 755, 100, 150]
    data["render"] = {"noise": None, "samples": 4, "light_step_mm": 4.0}
    data["detect"] = {"name": "lin2020", "min_area_px": 300}
    (folder / "scene.yaml").write_text(yaml.safe_dump(data))
    sweep = {
        "scene": "scene.yaml",
        "factors": {"detect.threshold": [90, 110]},
        "repeats": trials // 2,
    }
    path = folder / "sweep.yaml"
    path.write_text(yaml.safe_dump(sweep))
    return path


def resident_kb(process: int) -> int | None:
    """Give a process's resident memory, kB; None if it is gone."""
    try:
        text = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return None
    lines = [line for line in text.splitlines() if line.startswith("VmRSS")]
    return int(lines[0].split()[1]) if lines else None


def family(process: int) -> list[int]:
    """Give a process and its children."""
    try:
        text = Path(f"/proc/{process}/task/{process}/children").read_text()
    except OSError:
        return []
    return [process, *map(int, text.split())]


def main() -> None:
    """Run a sweep, watch it, print."""
    said = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    said.add_argument("--trials", type=int, default=5000)
    said.add_argument("--workers", type=int, default=2)
    given = said.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        out = folder / "out"
        command = [sys.executable, "-m", "simtip", "sweep", str(sweep_file(folder, given.trials))]
        options = ["-o", str(out), "--workers", str(given.workers), "--cache", str(folder / "c")]
        running = subprocess.Popen([*command, *options], stdout=subprocess.PIPE, text=True)
        samples: dict[int, list[tuple[int, int]]] = {}
        while running.poll() is None:
            time.sleep(EVERY_S)
            done = len(Table.open(out).keys()) if (out / "table.json").exists() else 0
            for process in family(running.pid):
                kb = resident_kb(process)
                if kb is not None:
                    samples.setdefault(process, []).append((done, kb))
        figures = {}
        for process, seen in samples.items():
            later = [kb for done, kb in seen if done >= given.trials // 10]
            if len(later) > 2:
                name_of = "coordinator" if process == running.pid else f"worker {process}"
                figures[name_of] = {
                    "mb_at_a_tenth": later[0] / 1024,
                    "mb_at_the_end": later[-1] / 1024,
                    "largest_ratio": max(later) / later[0],
                }
        print(json.dumps({"trials": given.trials, "code": running.returncode, **figures}, indent=1))


if __name__ == "__main__":
    main()
