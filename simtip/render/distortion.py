"""Lens distortion undone along the ray: no rendered image is ever warped."""

from __future__ import annotations

from typing import Any

from simtip.render.engine import dr, mi

NEWTON_STEPS = 6
"""From the distorted point; single precision is reached in four at the paper's field of view."""


class Distortion:
    """OpenCV's radial (also rational) and tangential distortion, in the renderer's own numbers."""

    def __init__(self, coefficients: tuple[float, ...]) -> None:
        padded = (*coefficients, *(0.0,) * (8 - len(coefficients)))
        k1, k2, p1, p2, k3, k4, k5, k6 = (dr.opaque(mi.Float, c) for c in padded)
        self._over, self._under, self._tangential = (k1, k2, k3), (k4, k5, k6), (p1, p2)

    def undo(self, x_d: Any, y_d: Any) -> tuple[Any, Any]:
        """Find the (x, y) = (X/Z, Y/Z) that is distorted to (x_d, y_d), by Newton's method."""
        x, y = x_d, y_d
        p1, p2 = self._tangential
        for _ in range(NEWTON_STEPS):
            r2 = x * x + y * y
            radial, slope = self._radial(r2)
            xy = x * y
            off_x = x * radial + 2 * p1 * xy + p2 * (r2 + 2 * x * x) - x_d
            off_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * xy - y_d
            xx = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x
            yy = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x
            cross = 2 * xy * slope + 2 * p1 * x + 2 * p2 * y
            inverse = dr.rcp(xx * yy - cross * cross)
            x, y = (
                x - (yy * off_x - cross * off_y) * inverse,
                y - (xx * off_y - cross * off_x) * inverse,
            )
        return x, y

    def _radial(self, r2: Any) -> tuple[Any, Any]:
        """Radial factor and its derivative with respect to r^2."""
        (k1, k2, k3), (k4, k5, k6) = self._over, self._under
        over = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        under = 1 + r2 * (k4 + r2 * (k5 + r2 * k6))
        d_over = k1 + r2 * (2 * k2 + r2 * 3 * k3)
        d_under = k4 + r2 * (2 * k5 + r2 * 3 * k6)
        return over / under, (d_over * under - over * d_under) / (under * under)
