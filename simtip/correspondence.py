"""The corrected pair of points: Hartley and Sturm, "Triangulation", CVIU 68 (1997)."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial

from simtip.geometry import Array, unit


def nearest_correspondence(left_px: Array, right_px: Array, F: Array) -> tuple[Array, Array]:
    """Move two points as little as possible onto each other's epipolar lines.

    Hartley and Sturm (1997): the pencil of epipolar planes has one parameter, and the squared
    distance to the pair of lines is stationary at the roots of a polynomial of degree 6. All
    real roots and the plane at infinity are compared, so the minimum is global.

    Parameters
    ----------
    left_px, right_px
        (2,) undistorted px; neither is an epipole.
    F
        (3, 3), ``p_l^T F p_r = 0``.

    Returns
    -------
    left, right
        (2,) px, with ``p_l^T F p_r = 0`` to rounding and the least possible
        ``|left - left_px|^2 + |right - right_px|^2``.
    """
    # With both points moved to the origin and the epipoles turned onto the u axes, at (1, 0, f)
    # and (1, 0, g), p_r^T G p_l = 0 with
    # G = [[f g d, -g c, -g d], [-f b, a, b], [-f d, c, d]].
    G = _moved_to(right_px).T @ F.T @ _moved_to(left_px)
    u, _, vt = np.linalg.svd(G)
    turn_left, turn_right = _onto_u_axis(vt[2]), _onto_u_axis(u[:, 2])
    e_left, e_right = turn_left @ vt[2], turn_right @ u[:, 2]
    G = turn_right @ G @ turn_left.T
    inner = G[1:, 1:] / np.linalg.norm(G[1:, 1:])
    foot_left, foot_right = _nearest_feet(inner, e_left[2] / e_left[0], e_right[2] / e_right[0])
    return left_px + foot_left @ turn_left[:2, :2], right_px + foot_right @ turn_right[:2, :2]


def _nearest_feet(inner: Array, f: float, g: float) -> tuple[Array, Array]:
    """Find the plane of the pencil whose two lines pass nearest to the origins; give their feet."""
    (a, b), (c, d) = inner
    # The plane t meets the left image in the line through (0, t), (t f, 1, -t), and the right
    # one in (-g (c t + d), a t + b, c t + d). The numerator of the derivative of the summed
    # squared distances:
    t, p, q = Polynomial([0, 1]), Polynomial([b, a]), Polynomial([d, c])
    slope = t * (p**2 + g**2 * q**2) ** 2 - (a * d - b * c) * (1 + f**2 * t**2) ** 2 * p * q
    # A leading coefficient that is next to nothing only has roots next to infinity, and the plane
    # there is a candidate of its own.
    negligible = 1e-60 * np.abs(slope.coef).max()
    roots = np.asarray(slope.trim(negligible).roots()).real
    # An eigenvalue is only as exact as the largest root; the wanted one is often far smaller.
    roots = np.concatenate([_newton_step(slope, _newton_step(slope, roots)), roots])
    # homogeneous (t, s), so that the plane at t = infinity is one candidate of the others' kind
    ts = np.append(roots, 1.0)
    ss = np.append(np.ones_like(roots), 0.0)
    left = np.stack([f * ts, ss, -ts], axis=1)
    at_s, ct_s = a * ts + b * ss, c * ts + d * ss
    right = np.stack([-g * ct_s, at_s, ct_s], axis=1)
    with np.errstate(over="ignore", invalid="ignore"):  # a foot at infinity is never the nearest
        feet_left, feet_right = _feet(left), _feet(right)
        cost = (feet_left**2).sum(axis=1) + (feet_right**2).sum(axis=1)
    best = int(np.nanargmin(cost))
    return feet_left[best], feet_right[best]


def _newton_step(polynomial: Polynomial, roots: Array) -> Array:
    """Improve simple roots (n,); leave those where there is no finite step."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        better: Array = roots - polynomial(roots) / polynomial.deriv()(roots)
    return np.where(np.isfinite(better), better, roots)


def _feet(lines: Array) -> Array:
    """Give the points (n, 2) of lines (n, 3) nearest to the origin; NaN for no line."""
    square = (lines[:, :2] ** 2).sum(axis=1, keepdims=True)
    feet: Array = -lines[:, :2] * lines[:, 2:] / np.where(square > 0, square, np.nan)
    return feet


def _moved_to(point: Array) -> Array:
    return np.array([[1.0, 0.0, point[0]], [0.0, 1.0, point[1]], [0.0, 0.0, 1.0]])


def _onto_u_axis(epipole: Array) -> Array:
    """Give the rotation (3, 3) of the image plane that turns the epipole (3,) onto the u axis."""
    cosine, sine = unit(epipole[:2])
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
