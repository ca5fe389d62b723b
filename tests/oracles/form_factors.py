"""Irradiance / pi under unit radiance, in closed form: configuration factors of lamps.

Lambert's polygon formula, and the finite cylinder, from J. R. Howell, "A catalog of radiation heat
transfer configuration factors" (elements B-3, B-4, B-31), typed here for the tests alone.
"""

from __future__ import annotations

import numpy as np


def polygon(corners: np.ndarray, point: np.ndarray, normal: np.ndarray) -> float:
    """Factor from a small plane to a polygon wholly before it; its corners run either way round."""
    towards = corners - point
    towards = towards / np.linalg.norm(towards, axis=1, keepdims=True)
    after = np.roll(towards, -1, axis=0)
    edge = np.cross(towards, after)
    length = np.linalg.norm(edge, axis=1)
    angle = np.arctan2(length, (towards * after).sum(axis=1))
    return abs(float((angle * (edge / length[:, None] @ normal)).sum())) / (2 * np.pi)


def parallel_rectangle(a: float, b: float, c: float) -> float:
    """Factor to a parallel a x b rectangle at distance c, one corner of which stands above."""
    x, y = a / c, b / c
    u, v = np.hypot(1, x), np.hypot(1, y)
    return float((x / u * np.arctan(y / u) + y / v * np.arctan(x / v)) / (2 * np.pi))


def upright_rectangle(a: float, b: float, c: float) -> float:
    """Factor to a rectangle at right angles, b along the edge they share and a high, c away.

    The small plane stands before one end of that edge.
    """
    x, y = a / b, c / b
    root = np.hypot(x, y)
    return float((np.arctan(1 / y) - y / root * np.arctan(1 / root)) / (2 * np.pi))


def cylinder_end(radius: float, length: float, distance: float) -> float:
    """Factor to a cylinder whose axis is square to the normal, which runs through one of its ends.

    `distance` is the axis's.
    """
    h, l = distance / radius, length / radius  # noqa: E741 (the formula's own letter)
    x, y = (1 + h) ** 2 + l**2, (1 - h) ** 2 + l**2
    far = (x - 2 * h) / np.sqrt(x * y) * np.arctan(np.sqrt(x * (h - 1) / (y * (h + 1))))
    near = np.arctan(np.sqrt((h - 1) / (h + 1)))
    return float(np.arctan(l / np.sqrt(h**2 - 1)) / (np.pi * h) + l / np.pi * (far - near) / h)


def inside(corners: np.ndarray, steps: int) -> np.ndarray:
    """Give (steps^2, 3) midpoints of a parallelogram's cells, of its first three corners."""
    u, v = np.meshgrid(*2 * [(np.arange(steps) + 0.5) / steps])
    origin, along, up = corners[0], corners[1] - corners[0], corners[3] - corners[0]
    return origin + u.reshape(-1, 1) * along + v.reshape(-1, 1) * up
