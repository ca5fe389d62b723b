"""What a calibration's error does in the working volume, slice by slice."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from simtip.calibrate import ErrorMap
from simtip.geometry import Array
from simtip.report.style import new_figure

SLICES = 3


def error_map_figure(found: ErrorMap) -> Figure:
    """Draw the displacement, what a rigid fit leaves of it, and steps' errors."""
    figure = new_figure(11, 10.6)
    rows: Any = figure.subfigures(3, 1, hspace=0.04)
    depths = np.unique(found.points_mm[:, 2])
    chosen = depths[np.unique(np.linspace(0, len(depths) - 1, SLICES).round().astype(int))]
    _vectors(rows[0], found, found.displacement_mm, chosen, "displacement")
    _vectors(
        rows[1], found, found.deformation_mm, chosen, "what a rigid fit of the volume leaves of it"
    )
    _steps(rows[2], found, float(chosen[len(chosen) // 2]))
    return figure


def _vectors(figure: SubFigure, found: ErrorMap, errors: Array, depths: Array, title: str) -> None:
    lengths = np.linalg.norm(errors, axis=1)
    figure.suptitle(
        f"{title}: mean {lengths.mean():.4f} mm, max {lengths.max():.4f} mm"
        " (colour: length; arrows: its part in x and y)",
        fontsize=11,
    )
    axes = np.atleast_1d(figure.subplots(1, len(depths), sharey=True))
    most = max(float(lengths.max()), 1e-12)
    flat = max(float(np.hypot(errors[:, 0], errors[:, 1]).max()), 1e-12)
    pitch = _pitch(found.points_mm[:, 0])
    for ax, depth in zip(axes, depths, strict=True):
        here = found.points_mm[:, 2] == depth
        mesh = _mesh(ax, found.points_mm[here], lengths[here], cmap="viridis", vmin=0, vmax=most)
        x, y = found.points_mm[here, 0], found.points_mm[here, 1]
        ax.quiver(
            x,
            y,
            errors[here, 0],
            errors[here, 1],
            angles="xy",
            scale_units="xy",
            scale=flat / (0.9 * pitch),
            color="white",
            ec="black",
            lw=0.3,
            width=0.008,
        )
        _label(ax, depth)
    axes[0].set_ylabel("y, mm (down)")
    figure.colorbar(mesh, ax=list(axes), label="mm")


def _steps(figure: SubFigure, found: ErrorMap, depth: float) -> None:
    here = found.points_mm[:, 2] == depth
    percent = found.step_percent
    figure.suptitle(
        f"error of the measured length of a {found.step_mm:g} mm step, % of the step, "
        f"at z = {depth:.1f} mm",
        fontsize=11,
    )
    axes = figure.subplots(1, 3, sharey=True)
    most = max(float(np.abs(percent).max()), 1e-12)
    for k, ax in enumerate(axes):
        mesh = _mesh(
            ax, found.points_mm[here], percent[here, k], cmap="RdBu_r", vmin=-most, vmax=most
        )
        mean, worst = np.abs(percent[:, k]).mean(), np.abs(percent[:, k]).max()
        ax.set_title(f"along {'xyz'[k]}; all: mean {mean:.2g} %, max {worst:.2g} %", fontsize=9.5)
        ax.set_xlabel("x, mm")
    axes[0].set_ylabel("y, mm (down)")
    figure.colorbar(mesh, ax=list(axes), label="%")


def _mesh(axes: Axes, points: Array, values: Array, **look: Any) -> Any:
    """Draw values at the points of a grid; places where there is none stay empty."""
    x, column = np.unique(points[:, 0], return_inverse=True)
    y, row = np.unique(points[:, 1], return_inverse=True)
    table = np.full((len(y), len(x)), np.nan)
    table[row, column] = values
    mesh = axes.pcolormesh(x, y, table, shading="nearest", **look)
    axes.set_aspect("equal")
    axes.set_ylim(axes.dataLim.y1, axes.dataLim.y0)
    return mesh


def _label(axes: Axes, depth: float) -> None:
    axes.set_title(f"z = {depth:.1f} mm", fontsize=9.5)
    axes.set_xlabel("x, mm")


def _pitch(values: Array) -> float:
    steps = np.diff(np.unique(values))
    return float(steps.min()) if len(steps) else 1.0
