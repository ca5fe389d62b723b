"""What a calibration's error does to positions and lengths, in millimetres.

Points of a working volume are projected with the true rig, without noise, and triangulated with the
calibrated one. What differs is due to the calibration alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from simtip.camera import StereoRig
from simtip.errors import InputError
from simtip.geometry import Array, Pose
from simtip.triangulate import Method, triangulate_points

STEP_MM = 2.0
"""The needle's step in the paper's experiments."""

MIN_POINTS = 4
"""A rigid transform is fitted to three points or more; then there is something left over."""


@dataclass(frozen=True, eq=False)
class ErrorMap:
    """Errors over a working volume; error = measured - true.

    Attributes
    ----------
    points_mm
        (n, 3) the points that both true cameras see, true rig's frame.
    displacement_mm
        (n, 3) where the calibrated rig puts them, less where they are. Both rigs' frames are their
        left cameras, so a turned or shifted left camera counts.
    rigid
        Measured frame from true frame, fitted to all points.
    deformation_mm
        (n, 3) what is left of the displacement after that: it alone harms distances.
    step_mm
        Length of the steps judged.
    step_error_mm
        (n, 3) error of the measured length of a step along x, y and z (paper Eq. 3), centred at
        the point.
    left_out
        Points of the grid outside either image, or with a step that ends there.
    failed
        Points that the calibrated rig could not triangulate.
    """

    points_mm: Array
    displacement_mm: Array
    rigid: Pose
    deformation_mm: Array
    step_mm: float
    step_error_mm: Array
    left_out: int
    failed: int

    @property
    def step_percent(self) -> Array:
        """(n, 3) the steps' errors in percent of the step."""
        percent: Array = 100 * self.step_error_mm / self.step_mm
        return percent

    def summary(self) -> dict[str, Any]:
        """Give lengths' mean and max, mm: all, after the rigid transform, and per step."""
        step = np.abs(self.step_error_mm)
        return {
            **_mean_and_max(self.displacement_mm),
            "points": len(self.points_mm),
            "left_out": self.left_out,
            "failed": self.failed,
            "deformation": _mean_and_max(self.deformation_mm),
            "step_mm": self.step_mm,
            "step": {
                axis: {
                    "mean": float(step[:, k].mean()),
                    "max": float(step[:, k].max()),
                    "bias": float(self.step_error_mm[:, k].mean()),
                    "mean_percent": float(100 * step[:, k].mean() / self.step_mm),
                    "max_percent": float(100 * step[:, k].max() / self.step_mm),
                }
                for k, axis in enumerate("xyz")
            },
        }


def error_map(
    true: StereoRig,
    calibrated: StereoRig,
    low_mm: ArrayLike,
    high_mm: ArrayLike,
    counts: tuple[int, int, int] = (9, 9, 9),
    *,
    step_mm: float = STEP_MM,
    method: Method = "svd",
) -> ErrorMap:
    """Map the error that a calibration alone causes.

    Parameters
    ----------
    true, calibrated
        The rig that takes the pictures and the one that measures in them.
    low_mm, high_mm
        (3,) corners of the working volume, mm, in the true left camera's frame.
    counts
        Points of the grid along x, y and z, faces included; one point is in the middle.
    step_mm
        Length of the steps, mm.
    method
        Of triangulation; see `simtip.triangulate`.

    Raises
    ------
    InputError
        The volume is turned inside out, or fewer than four of its points are seen by both cameras.
    """
    grid = _grid(
        np.asarray(low_mm, dtype=np.float64), np.asarray(high_mm, dtype=np.float64), counts
    )
    if not step_mm > 0:
        raise InputError(f"a step of {step_mm:g} mm has no length", field="step_mm")
    # (n, 7, 3): each point, then the ends of its three steps
    ends = step_mm / 2 * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
    places = grid[:, None] + ends
    left, right = true.project(places)
    seen = (true.left.contains(left) & true.right.contains(right)).all(axis=1)
    measured = np.full_like(places[seen], np.nan)
    if seen.any():
        measured = triangulate_points(left[seen], right[seen], calibrated, method)
    found = np.isfinite(measured).all(axis=(1, 2))
    if found.sum() < MIN_POINTS:
        raise InputError(
            f"both cameras see only {int(found.sum())} of the working volume's {len(grid)} points",
            field="volume",
            remedy="give a box in front of both cameras, mm",
        )
    points, measured = grid[seen][found], measured[found]
    rigid = _rigid(points, measured[:, 0])
    steps = np.linalg.norm(measured[:, 1:4] - measured[:, 4:7], axis=2)
    return ErrorMap(
        points_mm=points,
        displacement_mm=measured[:, 0] - points,
        rigid=rigid,
        deformation_mm=measured[:, 0] - rigid.apply(points),
        step_mm=float(step_mm),
        step_error_mm=steps - step_mm,
        left_out=int((~seen).sum()),
        failed=int((~found).sum()),
    )


def _grid(low: Array, high: Array, counts: tuple[int, int, int]) -> Array:
    if low.shape != (3,) or high.shape != (3,) or not (high >= low).all() or min(counts) < 1:
        raise InputError(
            "the working volume has to have low <= high in x, y and z, and points to measure at",
            field="volume",
            remedy="give (x, y, z) of its two corners, mm",
        )
    axes = [
        np.linspace(a, b, n) if n > 1 else np.array([(a + b) / 2])
        for a, b, n in zip(low, high, counts, strict=True)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def _rigid(points: Array, measured: Array) -> Pose:
    """Give the rigid transform of least squares from points to measured (Kabsch 1976)."""
    a, b = measured.mean(axis=0), points.mean(axis=0)
    u, _, vt = np.linalg.svd((measured - a).T @ (points - b))
    R = u @ np.diag([1.0, 1.0, np.linalg.det(u) * np.linalg.det(vt)]) @ vt
    return Pose(R, a - R @ b)


def _mean_and_max(vectors: Array) -> dict[str, float]:
    lengths = np.linalg.norm(vectors, axis=1)
    return {"mean": float(lengths.mean()), "max": float(lengths.max())}
