"""What a laser interferometer reads of a carriage."""

from __future__ import annotations

import numpy as np

from simtip.geometry import Array
from simtip.spec.experiment import InterferometerSpec

HALF_95 = 1.959963984540054
"""Standard deviations from the mean to the end of 95 % of a normal population."""


def readings(spec: InterferometerSpec, carriage_mm: Array, rng: np.random.Generator) -> Array:
    """Read the carriage's place along the first axis.

    Of a reading, ``x (1 + scale) cos(misalignment) + dead path x drift``, mm: cosine and dead path
    errors as in Renishaw's and NIST's accounts of linear measurement.

    Parameters
    ----------
    spec
        The interferometer.
    carriage_mm
        (runs, positions) from the datum, mm.
    rng
        Of its errors.

    Returns
    -------
    readings
        (runs, positions) mm.
    """
    scale = 1e-6 * spec.accuracy_ppm / HALF_95 * rng.standard_normal((len(carriage_mm), 1))
    drift = 1e-6 * spec.air_drift_ppm * rng.standard_normal(carriage_mm.shape)
    cosine = np.cos(1e-3 * spec.misalignment_mrad)
    read: Array = carriage_mm * (1 + scale) * cosine + spec.dead_path_mm * drift
    if spec.resolution_mm:
        read = np.round(read / spec.resolution_mm) * spec.resolution_mm
    return read
