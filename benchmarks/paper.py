"""The paper's figures and simtip's, side by side: the tables of docs/paper.md.

python benchmarks/paper.py --measure DIR    run the experiment and the budget, keep the figures
python benchmarks/paper.py                  print the tables
python benchmarks/paper.py --write          put them into docs/paper.md

A measurement takes an hour on two cores; interrupted, the same command goes on. `--replicates` are
the budget's.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
from environment import environment
from kept_file import keep_json
from marked import replaced

from simtip.boards import plan_boards
from simtip.budget.run import run_budget
from simtip.experiment.run import run_experiment
from simtip.recalibration import recalibrate
from simtip.scene_file import load_scene
from simtip.spec import SceneSpec
from simtip.sweep.campaign import Means
from simtip.sweep.table import Table

HERE = Path(__file__).resolve().parent
SCENE = HERE.parent / "scenes" / "paper" / "lin2020.yaml"
STORED = HERE / "figures" / "paper.json"
PAGE = HERE.parent / "docs" / "paper.md"
MARKS = {
    name: (f"<!-- {name}: begin -->", f"<!-- {name}: end -->") for name in ("figures", "budget")
}

Figures = dict[str, Any]


def measure(folder: Path, replicates: int) -> Figures:
    """Run everything, or go on with it."""
    scene, means = load_scene(SCENE), Means(cache=folder / "cache", cache_size="60GB")
    start = time.perf_counter()
    experiment = run_experiment(scene, folder / "mca", means).to_dict()
    budget = run_budget(scene, folder / "budget", means, replicates=replicates).to_dict()
    return {
        "environment": environment(),
        "calibration": calibration(scene),
        "experiment": experiment,
        "budget": budget,
        "detect_s": detect_s(folder / "mca"),
        "minutes": (time.perf_counter() - start) / 60,
    }


def calibration(scene: SceneSpec) -> Figures:
    """Calibrate the scene's rig once, from corners as noisy as the experiment's."""
    how = scene.experiment.calibration
    if how is None:
        raise ValueError("the paper's scene has no calibration")
    found = recalibrate(scene, how).to_dict()
    return {
        "points": len(plan_boards(scene, seed=how.seed).poses) * 88,
        "mean_px": found["mean_px"],
        "epipolar_rig_px": {key: found["epipolar_rig_px"][key] for key in ("mean", "max")},
    }


def detect_s(folder: Path) -> float:
    """Give how long the detector took for a pair, s, in the middle."""
    rows = Table.open(folder / "sweeps" / "00").by_trial().values()
    return float(np.median([row["detect_s"] for row in rows if row["detect_s"] is not None]))


def figures_table(told: Figures) -> str:
    """Give the paper's figures beside simtip's, as Markdown."""
    mca = told["experiment"]
    accuracy, agreement = mca["accuracy"], mca["agreement"]
    start, repeat = accuracy["from_start"], mca["repeatability"]
    calibrated, grr = told["calibration"], mca["grr"]
    epipolar = calibrated["epipolar_rig_px"]
    interval = _ends(agreement["bias_ci_mm"])
    rows = [
        ("reprojection error, left / right, px (Fig. 5)", "0.052 / 0.055",
         " / ".join(f"{calibrated['mean_px'][side]:.3f}" for side in ("left", "right"))),
        ("corner pairs", "1760", str(calibrated["points"])),
        ("epipolar distance, mean / max, px (Fig. 10)", "0.3807 / 0.5750",
         f"{epipolar['mean']:.4f} / {epipolar['max']:.4f}"),
        ("mean \\|error\\| of a step, mm (Fig. 11)", "0.2824", f"{accuracy['mean_abs_mm']:.4f}"),
        ("max \\|error\\| of a step, mm", "0.3621", f"{accuracy['max_abs_mm']:.4f}"),
        ("mean \\|error\\| from the start, mm", "", f"{start['mean_abs_mm']:.4f}"),
        ("R^2 of steps", "0.8794 (undefined)", f"{accuracy['r2_step']:.4f}"),
        ("R^2 of displacements", "", f"{accuracy['r2_cumulative']:.6f}"),
        ("bias, mm (Fig. 12)", "0.29", f"{agreement['bias_mm']:.4f} ({interval})"),
        ("SD of differences, mm", "0.07 or 0.14", f"{agreement['sd_mm']:.4f}"),
        ('"96 % interval" / 95 % limits, mm', "0.15 .. 0.43",
         f"{agreement['loa_lower_mm']:.3f} .. {agreement['loa_upper_mm']:.3f}"),
        ("Pearson r", "0.999847", f"{agreement['pearson_r']:.6f}"),
        ("Lin's concordance", "", f"{agreement['ccc']:.6f}"),
        ("sigma of repeatability, mm (Fig. 13)", "0.017",
         f"{repeat['sigma_mm']:.4f} ({_ends(repeat['sigma_ci_mm'])})"),
        ("P/T, %", "16.42", f"{repeat['p_t_percent']:.2f} ({_ends(repeat['p_t_ci_percent'])})"),
        ("gauge R&R, % of TV / of tolerance", "",
         f"{grr['grr_percent_tv']:.3f} / {grr['percent_tolerance']['grr']:.1f}"),
        ("absolute error of the tip, RMS, mm", "", f"{mca['position']['rms_mm']:.4f}"),
        ("the same in the robot's frame, RMS, mm", "",
         f"{mca['registration']['position_error_mm']['rms']:.4f}"),
        ("time of the extraction, a pair, s", "0.46", f"{told['detect_s']:.2f}"),
    ]  # fmt: skip
    head = ["| figure | paper | simtip |", "| --- | --- | --- |"]
    return "\n".join([*head, *(f"| {' | '.join(row)} |" for row in rows)])


def budget_table(told: Figures) -> str:
    """Give the budget's shares, as Markdown."""
    budget = told["budget"]
    kinds = ("position", "step", "from_start")
    shares = {kind: {row["cause"]: row for row in budget[kind]["shares"]} for kind in kinds}
    rows = [
        "| cause | position | step | from the start |",
        "| --- | --- | --- | --- |",
        "| **RMS error, mm** | "
        + " | ".join(f"**{budget[kind]['rms_mm']:.4f}**" for kind in kinds)
        + " |",
    ]
    for cause in shares["position"]:
        cells = [f"{shares[kind][cause]['percent']:.1f} %" for kind in kinds]
        rows.append(f"| {cause} | {' | '.join(cells)} |")
    return "\n".join(rows)


def _ends(interval: list[float]) -> str:
    return " .. ".join(f"{end:.4g}" for end in interval)


def written(text: str, name: str, new: str) -> str:
    """Put a table into its place in a page."""
    return replaced(text, new, *MARKS[name])


def main() -> None:
    """Measure, print or write."""
    said = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    said.add_argument("--measure", type=Path, metavar="DIR", help="and keep the figures")
    said.add_argument("--replicates", type=int, default=5, help="of the budget [5]")
    said.add_argument("--write", action="store_true", help="into docs/paper.md")
    given = said.parse_args()
    if given.measure is not None:
        keep_json(STORED, measure(given.measure, given.replicates))
    told = json.loads(STORED.read_text())
    tables = {"figures": figures_table(told), "budget": budget_table(told)}
    if given.write:
        page = PAGE.read_text()
        for name, table in tables.items():
            page = written(page, name, table)
        PAGE.write_text(page)
    else:
        print("\n\n".join(tables.values()))


if __name__ == "__main__":
    main()
