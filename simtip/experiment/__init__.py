"""The measurement capability experiment of Lin et al. (2020), section 4, on a rendered system.

`stage` and `interferometer` say what is driven and what it is held against, `series` which trials
that makes, `performed` works them out as sweeps, `analysis` is what comes of it.
"""
