"""Is the table of sample points, whose numbers are written down, the one that SciPy makes?"""

from __future__ import annotations

import numpy as np
from scipy.stats import qmc

from simtip.render.sobol_table import COLUMNS, TABLE_POINTS, TABLE_SEED, table


def test_they_are_scipys_bit_for_bit():
    points = qmc.Sobol(COLUMNS, scramble=True, rng=TABLE_SEED).random(TABLE_POINTS)
    np.testing.assert_array_equal(table(), (points.T * 2.0**32).astype(np.uint32))
