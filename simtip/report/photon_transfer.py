"""The photon-transfer plot: temporal variance against mean, and the line that gives K."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.figure import Figure

from simtip.emva import CameraCharacteristics

BLUE, ORANGE, GRAY = "#0072B2", "#D55E00", "#666666"


def plot_photon_transfer(found: CameraCharacteristics, kind: str) -> bytes:
    """Draw the plot as a "png" or "svg" file."""
    dark = found.photon_transfer[0]
    mean = np.array([level.mean_dn for level in found.photon_transfer]) - dark.mean_dn
    variance = np.array([level.variance_dn2 for level in found.photon_transfer])
    used = np.array(found.in_fit)
    figure = Figure(figsize=(7, 4.4), layout="constrained")
    axes = figure.subplots()
    axes.plot(mean[used], variance[used], "o", ms=5, color=BLUE, label="in the fit")
    axes.plot(mean[~used], variance[~used], "o", ms=5, mfc="none", color=GRAY, label="not in it")
    gain = found.K_dn_per_e.value
    if gain is not None and found.sigma_d_e.value is not None:
        x = np.array([0.0, mean.max()])
        start = gain**2 * found.sigma_d_e.value**2 + 1 / 12
        label = f"K = {gain:.5g} DN/e$^-$, $\\sigma_d$ = {found.sigma_d_e.value:.3g} e$^-$"
        axes.plot(x, start + gain * x, color=ORANGE, lw=1.5, label=label)
    axes.set_xlabel("mean above dark, DN")
    axes.set_ylabel("temporal variance, DN$^2$")
    axes.set_ylim(0, 1.15 * variance.max())
    axes.set_xlim(left=-0.02 * mean.max())
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25)
    axes.legend(frameon=False)
    file = io.BytesIO()
    figure.savefig(file, format=kind, dpi=150)
    return file.getvalue()
