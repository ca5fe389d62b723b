"""The bound as tables on the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

UM = 1000.0


def show_bound(result: dict[str, Any]) -> None:
    """Print the bound in space and in both images, and how far it has converged."""
    console = Console()
    space = Table(title="least standard deviation of the tip, um")
    for heading in ("", "nuisances free", "known"):
        space.add_column(heading, justify="left" if not heading else "right")
    for key, free, known in (
        *((name, "bound_mm", "bound_known_mm") for name in ("x", "y", "z", "norm")),
        *((name, "bound_axis_mm", "bound_axis_known_mm") for name in ("along", "across", "depth")),
    ):
        space.add_row(key, _scaled(result[free][key], UM), _scaled(result[known][key], UM))
    console.print(space)
    images = Table(title="in one image alone, px")
    for heading in ("", "nuisances free", "known"):
        images.add_column(heading, justify="left" if not heading else "right")
    for side in ("left", "right"):
        for key in ("along", "across"):
            images.add_row(
                f"{side}, {key}",
                _scaled(result["bound_px"][side][key]),
                _scaled(result["bound_known_px"][side][key]),
            )
    console.print(images)
    ratios = result["convergence"]
    told = [
        f"half the {name[5:]}: times {_scaled(ratios.get(name))}"
        for name in ("half_step", "half_samples")
        if name in ratios
    ]
    if result["without_effect"]:
        told.append(f"without effect on the images: {', '.join(result['without_effect'])}")
    console.print("; ".join(told), markup=False, highlight=False)


def _scaled(value: float | None, factor: float = 1.0) -> str:
    return "not determined" if value is None else f"{factor * value:.4g}"
