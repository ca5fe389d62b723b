"""The Fisher information of one reading, from the probabilities of all its codes."""

from __future__ import annotations

import numpy as np
from scipy import stats

SPAN = 10.0


def exact_information(mean_e, *, gain, black, bits, read_e, full_well_e):
    """Add up (dp/dmu)^2 / p over codes: Poisson electrons, full well, normal noise, rounding."""
    reach = SPAN * np.sqrt(mean_e) + 20
    n = np.arange(max(0, int(mean_e - reach)), int(mean_e + reach) + 1)
    chance = stats.poisson.pmf(n, mean_e)
    change = chance * (n / mean_e - 1)
    top = 2**bits - 1
    edges = (np.arange(top + 2) - 0.5 - black) / gain
    edges[0], edges[-1] = -np.inf, np.inf
    near = (edges > n[0] - SPAN * read_e - 2 / gain) & (edges < n[-1] + SPAN * read_e + 2 / gain)
    edges = np.unique(np.concatenate([[-np.inf], edges[near], [np.inf]]))
    filled = np.minimum(n, full_well_e)
    below = stats.norm.cdf((edges[:, None] - filled) / read_e)
    codes = np.diff(below, axis=0)
    p, dp = codes @ chance, codes @ change
    some = p > 1e-280
    return float((dp[some] ** 2 / p[some]).sum())
