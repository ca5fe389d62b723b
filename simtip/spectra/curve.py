"""Functions of wavelength, and their exact integrals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from simtip.geometry import Array

VISIBLE_NM = (380.0, 780.0)
"""Where light is counted; all spectra and radiant powers mean this range."""

_GAUSS = 0.5 / np.sqrt(3)  # nodes of the two-point rule, from the middle, per width


@dataclass(frozen=True, eq=False)
class Curve:
    """A function of wavelength.

    Attributes
    ----------
    breaks_nm
        Rising wavelengths, nm, between which it is smooth.
    at
        Gives values (n,) or (n, 3) at wavelengths (n,), nm.
    """

    breaks_nm: Array
    at: Callable[[Array], Array]


def tabulated(wavelength_nm: Array, value: Array) -> Curve:
    """Give straight lines between the values (n,) or (n, 3) of a table, and 0 beyond it."""

    def at(nm: Array) -> Array:
        if value.ndim == 1:
            return np.interp(nm, wavelength_nm, value, left=0, right=0)
        each = [np.interp(nm, wavelength_nm, column, left=0, right=0) for column in value.T]
        return np.stack(each, axis=-1)

    return Curve(wavelength_nm, at)


def integral(integrand: Callable[[Array], Array], *curves: Curve) -> Array:
    """Integrate over the visible range: the product of three straight-line curves exactly.

    Between any two neighbouring breaks of the curves, Gauss's rule with two points takes a cubic
    without error.

    Parameters
    ----------
    integrand
        Gives (n,) or (n, 3) at wavelengths (n,), nm.
    curves
        What it is made of: their breaks are used.
    """
    inner = np.concatenate([curve.breaks_nm for curve in curves])
    inside = inner[(inner > VISIBLE_NM[0]) & (inner < VISIBLE_NM[1])]
    edges = np.unique(np.concatenate([VISIBLE_NM, inside]))
    width, middle = np.diff(edges), (edges[1:] + edges[:-1]) / 2
    nm = (middle + np.array([[-_GAUSS], [_GAUSS]]) * width).ravel()
    weight = np.tile(width / 2, 2)
    area: Array = np.tensordot(weight, integrand(nm), axes=1)
    return area
