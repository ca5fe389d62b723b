"""Turn the JSON of the benchmarks into the table of README.md.

python benchmarks/table.py --measure     run every benchmark, keep its JSON in figures/
python benchmarks/table.py               print the table from figures/
python benchmarks/table.py --write       put it into README.md, between its two marks
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
FIGURES = HERE / "figures"
README = HERE / "README.md"
BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"

ROWS: dict[str, tuple[tuple[str, str, str], ...]] = {
    "render": (
        ("a pair at the scene's own noise, wall", "pair_at_scenes_noise.wall_s", "{:.1f} s"),
        ("the same, CPU", "pair_at_scenes_noise.cpu_s", "{:.1f} s"),
        ("**left view to 0.5 % / 1 % noise, CPU: simtip**", "cpu_s_simtip", "{:.1f} s"),
        ("its noise on the background", "noise_background", "{:.2%}"),
        ("its noise on the needle's flank", "noise_flank", "{:.2%}"),
        ("the same, as the renderer claims", "noise_flank_claimed", "{:.2%}"),
        ("samples traced, all cores", "msamples_per_s", "{:.1f} M/s"),
        ("**CPU for the same noise: `path`**", "cpu_s_path", "{:.0f} s"),
        ("**ratio**", "ratio", "{:.0f}"),
        ("ratio, `path` helped by weights", "ratio_to_room_weighted_path", "{:.0f}"),
        ("ratio, `path` for the background alone", "ratio_to_path_for_background_alone", "{:.0f}"),
        ("radiance simtip / `path`, background", "radiance_simtip_to_path.background", "{:.4f}"),
        ("radiance simtip / `path`, flank", "radiance_simtip_to_path.flank", "{:.4f}"),
    ),
    "mix": (
        ("a pair with four lamps rendered, CPU", "render_cpu_s", "{:.1f} s"),
        ("the same mixed anew, CPU", "mix_cpu_s.global", "{:.3f} s"),
        ("mixed for a rolling shutter, CPU", "mix_cpu_s.rolling", "{:.3f} s"),
        ("**share of rendering**", "ratio_to_rendering.global", "{:.2%}"),
        ("**share, rolling shutter**", "ratio_to_rendering.rolling", "{:.2%}"),
        ("share, from light files", "ratio_from_files_to_rendering", "{:.1%}"),
        ("two light files", "files.size_mb", "{:.0f} MB"),
    ),
    "sensor": (
        ("one bright image", "expose_s.bright", "{:.2f} s"),
        ("ratio to six fills with normal numbers", "ratio_to_normal_fills.bright", "{:.2f}"),
        ("the same for a dark image", "ratio_to_normal_fills.dark", "{:.2f}"),
    ),
    "psf": (
        ("one image, diffraction and aberration, f/1.4", "blur_s.both", "{:.3f} s"),
        ("the same, diffraction alone", "blur_s.diffraction", "{:.3f} s"),
        ("time / OpenCV's Gaussian alone", "ratio_to_opencv_gaussian", "{:.1f}"),
    ),
    "detect": (
        ("a pair, one thread", "pair_s", "{:.4f} s"),
        ("**ratio, plain steps / simtip**", "ratio_to_plain_steps", "{:.0f}"),
        ("a pair, with all layers", "with_layers_pair_s", "{:.3f} s"),
        ("time / bare OpenCV's on whole images", "ratio_to_bare_opencv", "{:.2f}"),
        ("on whole images, share of gray", "share_of_steps.to_gray", "{:.0%}"),
        ("share of the median", "share_of_steps.median_filter", "{:.0%}"),
        ("share of the threshold", "share_of_steps.binarise", "{:.0%}"),
        ("share of small components", "share_of_steps.remove_small_components", "{:.0%}"),
        ("share of Canny", "share_of_steps.edges", "{:.0%}"),
        ("share of the lowest pixel", "share_of_steps.lowest_edge_pixel", "{:.0%}"),
        ("share of the axis", "share_of_steps.needle_axis", "{:.0%}"),
        ("`subpixel`: time / the plain steps', a cone", "subpixel_over_plain_steps.cone", "{:.2f}"),
        ("the same for a bevel", "subpixel_over_plain_steps.bevel", "{:.2f}"),
    ),
    "sweep": (
        ("2000 trials of one render, 20 pairs: plain script", "plain_script.wall_s", "{:.0f} s"),
        ("the same by `simtip sweep`, one worker", "one_worker.wall_s", "{:.0f} s"),
        ("**time / the plain script's**", "ratio_to_plain_script", "{:.2f}"),
        ("time / that of its stages alone", "ratio_to_stages_alone", "{:.2f}"),
        ("new images, one worker's rate / bare calls'", "ratio_one_worker_to_bare", "{:.2f}"),
        ("two workers' / one's", "ratio_two_workers_to_one", "{:.2f}"),
    ),
    "match": (
        ("one by one, with reasons", "match_tips_pairs_per_s", "{:,.0f} pairs/s"),
        ("in bulk", "epipolar_distances_pairs_per_s", "{:,.0f} pairs/s"),
        ("time in bulk / OpenCV's", "ratio_to_opencv", "{:.2f}"),
    ),
    "triangulate": (
        ("`svd`, one by one, with checks", "methods.svd.single_pairs_per_s", "{:,.0f} pairs/s"),
        ("`midpoint`, one by one", "methods.midpoint.single_pairs_per_s", "{:,.0f} pairs/s"),
        ("`optimal`, one by one", "methods.optimal.single_pairs_per_s", "{:,.0f} pairs/s"),
        ("`svd` in bulk / OpenCV's time", "methods.svd.bulk_ratio_to_opencv", "{:.1f}"),
        ("`midpoint` in bulk / OpenCV's time", "methods.midpoint.bulk_ratio_to_opencv", "{:.2f}"),
        ("`optimal` in bulk / OpenCV's time", "methods.optimal.bulk_ratio_to_opencv", "{:.0f}"),
        (
            "`optimal` in bulk / `correctMatches`",
            "methods.optimal.bulk_ratio_to_correct_matches",
            "{:.0f}",
        ),
    ),
    "run": (
        ("`simtip --version`", "version_only_s", "{:.2f} s"),
        ("cold", "cold.wall_s", "{:.1f} s"),
        ("warm", "warm.wall_s", "{:.1f} s"),
        ("share of rendering, warm", "warm.share_of_rendering", "{:.0%}"),
    ),
}


def figure(result: dict[str, Any], path: str) -> float:
    """Look up a figure by its dotted path."""
    value: Any = result
    for key in path.split("."):
        value = value[key]
    return float(value)


def table(results: dict[str, dict[str, Any]]) -> str:
    """Make the Markdown table, and a line that says where it was measured."""
    lines = ["| benchmark | what | figure |", "| --- | --- | ---: |"]
    for name, rows in ROWS.items():
        for k, (what, path, form) in enumerate(rows):
            first = name if k == 0 else ""
            lines.append(f"| {first} | {what} | {form.format(figure(results[name], path))} |")
    where = results["render"]["environment"]
    versions = ", ".join(f"{package} {v}" for package, v in where["versions"].items())
    machine = f"{where['cpu_usable']} processor cores"
    said = f"Measured on {machine}, {where['platform']}, Python {where['python']}, {versions}."
    return "\n".join([said, "", *lines])


def stored() -> dict[str, dict[str, Any]]:
    """Read the JSON that was kept."""
    return {name: json.loads((FIGURES / f"{name}.json").read_text()) for name in ROWS}


def measure(names: list[str]) -> None:
    """Run benchmarks one after the other and keep their JSON."""
    FIGURES.mkdir(exist_ok=True)
    for name in names:
        print(f"bench_{name}.py ...", file=sys.stderr)
        done = subprocess.run(
            [sys.executable, str(HERE / f"bench_{name}.py")],
            check=True,
            stdout=subprocess.PIPE,
            text=True,
        )
        (FIGURES / f"{name}.json").write_text(done.stdout)


def written(text: str, new: str) -> str:
    """Replace what is between the marks."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{new}\n{END}{after}"


def main() -> None:
    """Measure, print or write."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument(
        "--measure", nargs="*", choices=ROWS, metavar="NAME", help="all, or those named"
    )
    arguments.add_argument("--write", action="store_true", help="into README.md")
    given = arguments.parse_args()
    if given.measure is not None:
        measure(given.measure or list(ROWS))
    elif given.write:
        README.write_text(written(README.read_text(), table(stored())))
    else:
        print(table(stored()))


if __name__ == "__main__":
    main()
