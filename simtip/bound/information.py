"""Fisher information of named parameters, and the bounds that follow from it.

``I = sum over pixels of D W D^T``, D the derivatives of the expected image, W the information of a
reading about its mean. Derivatives from Monte-Carlo renders carry noise, and its energy would add
to I. So they come in R independent replicas, and only products of different replicas count:

    ``I = ( (sum_r D_r) W (sum_r D_r)^T - sum_r D_r W D_r^T ) / (R (R - 1))``

whose mean is free of the noise. (It is a U-statistic.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array

NOTICEABLE = 0.25
"""A direction whose information is below so much of its own Monte-Carlo noise energy has none."""

RANK_TOLERANCE = 1e-9
"""The same without noise: of the largest eigenvalue, each parameter scaled to information 1."""

SHARE = 1e-3
"""A direction without information leaves a parameter undetermined if it has so much of it, in
amplitude, both measured by what the parameter alone would do to the image."""


@dataclass(frozen=True, eq=False)
class Information:
    """Fisher information about parameters.

    Attributes
    ----------
    names
        Of the p parameters.
    matrix
        (p, p) information, free of the noise's energy on average; units 1 / (unit_i unit_j).
    noise
        (p, p) energy of the Monte-Carlo noise in the mean derivatives, likewise.
    """

    names: tuple[str, ...]
    matrix: Array
    noise: Array

    @classmethod
    def from_derivatives(
        cls, names: Sequence[str], derivatives: ArrayLike, weights: ArrayLike
    ) -> Information:
        """Add up what pixels tell.

        Parameters
        ----------
        names
            Of the p parameters.
        derivatives
            (R, p, n): of R >= 2 independent replicas, p parameters, n readings.
        weights
            (n,) information of each reading about its mean.

        Raises
        ------
        ValueError
            Shapes that do not fit, or fewer than two replicas.
        """
        d, w = np.asarray(derivatives), np.asarray(weights, dtype=np.float64)
        if d.ndim != 3 or d.shape[1] != len(names) or d.shape[2:] != w.shape or len(d) < 2:
            raise ValueError(
                f"derivatives {d.shape} do not fit {len(names)} parameters and weights {w.shape}"
            )
        replicas = len(d)
        own = [_gram(each, w) for each in d]
        alone = np.sum(own, axis=0)
        together = _gram(d.sum(axis=0, dtype=np.float64), w)
        matrix = (together - alone) / (replicas * (replicas - 1))
        return cls(tuple(names), matrix, together / replicas**2 - matrix)

    def __add__(self, other: Information) -> Information:
        names = (*self.names, *(name for name in other.names if name not in self.names))
        matrix, noise = (np.zeros((len(names), len(names))) for _ in range(2))
        for part in (self, other):
            place = np.ix_(*[[names.index(name) for name in part.names]] * 2)
            matrix[place] += part.matrix
            noise[place] += part.noise
        return Information(names, matrix, noise)

    def of(self, names: Sequence[str]) -> Information:
        """Give the information about some parameters, the others known."""
        place = np.ix_(*[[self.names.index(name) for name in names]] * 2)
        return Information(tuple(names), self.matrix[place], self.noise[place])

    def transformed(self, names: Sequence[str], basis: Array) -> Information:
        """Give the information about other parameters: ``old = basis @ new``, (p, q)."""
        return Information(
            tuple(names), basis.T @ self.matrix @ basis, basis.T @ self.noise @ basis
        )

    def silent(self) -> tuple[str, ...]:
        """Name the parameters that do not change the image, as far as can be told."""
        signal, noise = np.diag(self.matrix), np.diag(self.noise)
        quiet = signal <= np.maximum(NOTICEABLE * noise, 0)
        return tuple(name for name, is_quiet in zip(self.names, quiet, strict=True) if is_quiet)

    def deviations(self, combinations: dict[str, float] | Sequence[dict[str, float]]) -> Array:
        """Give the Cramer-Rao bound (k,) of linear combinations, all parameters unknown.

        Parameters that do not change the image are left out; directions in which several together
        do not are projected out.

        Parameters
        ----------
        combinations
            k of them: each parameter's factor, by name.

        Returns
        -------
        deviations
            Standard deviations; inf where the image does not determine the combination.
        """
        wanted = [combinations] if isinstance(combinations, dict) else combinations
        silent = self.silent()
        left = self.of([name for name in self.names if name not in silent])
        factors = np.array([[c.get(name, 0.0) for name in left.names] for c in wanted])
        lost = np.array([any(c.get(name, 0.0) for name in silent) for c in wanted])
        found = _deviations(left, factors) if left.names else np.full(len(wanted), np.inf)
        return np.where(lost, np.inf, found)


def _deviations(about: Information, factors: Array) -> Array:
    """Give the bounds (k,) of combinations (k, p) of parameters that all have information."""
    # Scaled by what each does to the image alone, so that units do not matter.
    scale = 1 / np.sqrt(np.diag(about.matrix))
    value, vector = np.linalg.eigh(about.matrix * np.outer(scale, scale))
    noise = np.einsum("ij,ik,kj->j", vector, about.noise * np.outer(scale, scale), vector)
    limit = np.maximum(NOTICEABLE * noise, RANK_TOLERANCE * value[-1])
    kept = value > limit
    parts = (factors * scale) @ vector
    variance = (parts[:, kept] ** 2 / value[kept]).sum(axis=1)
    size = np.linalg.norm(factors * scale, axis=1)
    lost = np.linalg.norm(parts[:, ~kept], axis=1) > SHARE * size
    return np.asarray(np.where(lost, np.inf, np.sqrt(variance)))


def _gram(derivatives: Array, weights: Array) -> Array:
    rows = derivatives.astype(np.float64) * np.sqrt(weights)
    return np.asarray(rows @ rows.T)
