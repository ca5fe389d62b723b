"""The tips under test, and what each sharp one is, written down a second time from its docstring.

Half-spaces are (normal out of the solid (3,), point (3,)) in some frame along z; `solid_of` shifts
them so that the foremost point has z = 0. R = 0.835.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from simtip.needle import (
    BackBevel,
    Bevel,
    Blunt,
    Cone,
    Diamond,
    Franseen,
    Lancet,
    Trocar,
)

R = 0.835
BORE = 0.72 * R

SHARP = {
    "cone": Cone(5.0),
    "bevel": Bevel(20.0),
    "back_bevel": BackBevel(),
    "lancet": Lancet(),
    "trocar": Trocar(),
    "diamond": Diamond(25.0),
    "franseen": Franseen(),
    "blunt": Blunt(),
}
ROUND = {
    "cone": Cone(5.0, 0.06),
    "bevel": Bevel(20.0, 0.03),
    "back_bevel": BackBevel(tip_radius_mm=0.04),
    "lancet": Lancet(tip_radius_mm=0.05),
    "trocar": Trocar(20.0, 0.05),
    "diamond": Diamond(25.0, 0.3),
    "franseen": Franseen(tip_radius_mm=0.05),
    "blunt": Blunt(0.2),
}


def grind(angle_deg, towards_deg, point):
    """A plane at an angle to the axis, whose normal leans towards an azimuth."""
    a, t = np.radians(angle_deg), np.radians(towards_deg)
    return np.array([np.cos(a) * np.cos(t), np.cos(a) * np.sin(t), -np.sin(a)]), np.array(point)


def half_spaces(name):
    """The ground planes of a sharp tip; the cone is the odd one, and has none."""
    if name == "bevel":
        return [grind(20, 180, (R, 0, 0))]
    if name == "lancet":
        # The side bevels end on the rim half-way along the first bevel, where the angle is 90.
        sides = [grind(18, 180 + turn, (R, 0, 0)) for turn in (-35, 35)]
        end_z = -(sides[0][0] @ (np.array([0, R, 0]) - sides[0][1])) / sides[0][0][2]
        return [*sides, grind(12, 180, (0, R, end_z))]
    if name == "back_bevel":
        tip = (0.75 * R, 0, 0)
        return [grind(12, 180, tip), grind(18, 35, tip), grind(18, -35, tip)]
    if name in {"trocar", "franseen"}:
        return [grind(20, t, (0, 0, 0)) for t in (60, 180, 300)]
    if name == "diamond":
        return [grind(25, t, (0, 0, 0)) for t in (45, 135, 225, 315)]
    return [(np.array([0, 0, -1.0]), np.zeros(3))]  # blunt


@lru_cache
def planes_of(name, r=0.0):
    """Normals (k, 3) and offsets (k,) with ``normal . p <= offset``: where a ball's centre can be.

    For r = 0 the solid's own planes. The foremost ball, so also its point at z = 0, decides z.
    """
    normals, points = (np.array(a) for a in zip(*half_spaces(name), strict=True))
    offsets = (normals * points).sum(axis=1) - r
    # z of the front over a point: the largest of (n_x x + n_y y - offset) / -n_z.
    rho = np.linspace(BORE + r if name == "franseen" else 0, R - r, 1501)
    angle = np.radians(np.arange(0, 360, 1.0))
    x, y = (rho[:, None] * f(angle) for f in (np.cos, np.sin))
    front = front_z(normals, offsets, x, y)
    k = np.unravel_index(np.argmin(front), front.shape)
    best = front[k]
    if name == "back_bevel":  # not on that grid: where two lines in y = 0 meet
        (nx, _, nz), (mx, _, mz) = normals[:2]
        x = (offsets[1] / mz - offsets[0] / nz) / (mx / mz - nx / nz)
        best = front_z(normals, offsets, x, 0.0)
    return normals, offsets + normals[:, 2] * (r - best)


def front_z(normals, offsets, x, y):
    """Z of the highest plane over points."""
    shape = (-1,) + (1,) * np.ndim(x)
    n = [normals[:, k].reshape(shape) for k in range(3)]
    return ((n[0] * x + n[1] * y - offsets.reshape(shape)) / -n[2]).max(axis=0)


def depth(name, points, length):
    """How far points (n, 3) are inside a sharp solid; negative outside, by at most that much."""
    x, y, z = points.T
    rho = np.hypot(x, y)
    walls = [R - rho, length - z]
    if name == "cone":
        walls.append((R * z - 5 * rho) / np.hypot(5, R))
        return np.min(walls, axis=0)
    normals, offsets = planes_of(name)
    walls.append((offsets[:, None] - normals @ points.T).min(axis=0))
    if name == "franseen":
        floor = front_z(normals, offsets, *(R * np.array([[0.5], [3**0.5 / 2]]))) + 8 * R
        walls.append(np.maximum(rho - BORE, z - floor))
    return np.min(walls, axis=0)
