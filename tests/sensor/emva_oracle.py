"""The sensor's exact distribution of digital numbers, by summing probabilities: no sampling.

``P(DN = d) = sum over n of Poisson(n; mu) P(d is what K (n + read noise) + black rounds to)``,
with everything at or beyond the full well gathered there, and both ends of the range likewise.
"""

from __future__ import annotations

import numpy as np
from scipy import stats


def dn_probabilities(mean_e, spec):
    """P(DN = 0 .. 2^bits - 1) for one pixel that collects `mean_e` electrons on average."""
    well = int(spec.full_well_e)
    n = np.arange(well + 1)
    weight = stats.poisson.pmf(n, mean_e)
    weight[-1] = stats.poisson.sf(well - 1, mean_e)
    between = np.arange(2**spec.bit_depth - 1) + 0.5
    edges = np.concatenate([[-np.inf], between, [np.inf]])
    centre = spec.gain_dn_per_e * n + spec.black_level_dn
    keep = weight > 1e-18
    below = stats.norm.cdf(
        (edges[None, :] - centre[keep, None]) / (spec.gain_dn_per_e * spec.read_noise_e)
    )
    return weight[keep] @ np.diff(below, axis=1)


def moments(probabilities):
    """Mean and variance of the digital number."""
    dn = np.arange(len(probabilities))
    mean = probabilities @ dn
    return mean, probabilities @ (dn - mean) ** 2
