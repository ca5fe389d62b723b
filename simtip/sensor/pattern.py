"""What differs from pixel to pixel and stays: the fingerprint of one camera."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from simtip.seeding import stream
from simtip.spec import CameraSpec, SensorSpec

Floats = NDArray[np.float32]
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class FixedPattern:
    """Fixed differences between the pixels that are read out; None is no difference.

    Attributes
    ----------
    response
        (H, W, 3) relative to the mean response: PRNU, and 0 for dead pixels.
    dsnu_e
        (H, W, 3) dark signal less its mean, e-.
    hot
        (n,) rising flat indices into (H, W, 3) of pixels with extra dark current.
    origin
        x, y on the full sensor of the first pixel: where the colour mosaic begins.
    """

    response: Floats | None = None
    dsnu_e: Floats | None = None
    hot: Indices | None = None
    origin: tuple[int, int] = (0, 0)

    @cached_property
    def lowest_dsnu_e(self) -> float:
        """The lowest dark signal, e-."""
        return 0.0 if self.dsnu_e is None else float(self.dsnu_e.min())


UNIFORM = FixedPattern()
"""A camera whose pixels are all alike."""


def fixed_pattern(spec: SensorSpec, camera: CameraSpec, side: str) -> FixedPattern:
    """Give the fixed pattern of one camera.

    It depends on the spec's `fixed_pattern_seed`, the side and the size of the full sensor, and on
    no frame's seed. A region of interest shows its part of the same pattern, and a larger PRNU or
    DSNU the same pattern scaled. Channels are independent; with a mosaic, a pixel uses one of
    them. The last two patterns are kept.

    Parameters
    ----------
    spec
        The sensor; what its figures or switches leave out is None.
    camera
        Size and region of interest.
    side
        "left" or "right".
    """
    on = spec.effects
    return _pattern(
        spec.fixed_pattern_seed,
        side,
        (camera.height, camera.width),
        camera.roi or (0, 0, camera.width, camera.height),
        spec.prnu_percent / 100 * on.prnu,
        spec.dsnu_e * on.dsnu,
        spec.dead_fraction * on.defects,
        spec.hot_fraction * on.defects * on.dark_current,
    )


@lru_cache(maxsize=2)
def _pattern(
    seed: int,
    side: str,
    size: tuple[int, int],
    roi: tuple[int, int, int, int],
    prnu: float,
    dsnu_e: float,
    dead_fraction: float,
    hot_fraction: float,
) -> FixedPattern:
    shape = (*size, 3)
    x, y, width, height = roi
    part = (slice(y, y + height), slice(x, x + width))

    def normal(name: str) -> Floats:
        rng = stream(seed, "fixed pattern", side, name)
        return np.ascontiguousarray(rng.standard_normal(shape, dtype=np.float32)[part])

    def chosen(name: str, fraction: float) -> NDArray[np.bool_]:
        rng = stream(seed, "fixed pattern", side, name)
        return np.ascontiguousarray((rng.random(shape, dtype=np.float32) < fraction)[part])

    response = dsnu = hot = None
    if prnu:
        # A response below zero, five standard deviations off at the worst, is none.
        response = np.maximum(1 + np.float32(prnu) * normal("prnu"), 0)
    if dead_fraction:
        alive = ~chosen("dead", dead_fraction)
        response = alive.astype(np.float32) if response is None else response * alive
    if dsnu_e:
        dsnu = normal("dsnu") * np.float32(dsnu_e)
    if hot_fraction:
        hot = np.flatnonzero(chosen("hot", hot_fraction))
    for array in (response, dsnu, hot):
        if array is not None:
            array.flags.writeable = False
    return FixedPattern(response, dsnu, hot, (x, y))
