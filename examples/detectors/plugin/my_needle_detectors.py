"""A package with a detector for simtip, which also shows parameters with ranges, and layers."""

from typing import Annotated

import numpy as np

from simtip.detect import Image, TipObservation, TipStatus
from simtip.detect.parameters import Declared


def darkest_column(
    image: Image,
    *,
    contrast: Annotated[
        float, Declared("least step from needle to background, DN", minimum=1, maximum=65535)
    ] = 30.0,
    layers: bool = False,
) -> TipObservation:
    """Follow the darkest column down to its steepest step (a needle that points down)."""
    gray = image.mean(axis=2) if image.ndim == 3 else image.astype(np.float64)
    kept = {"gray": gray} if layers else {}
    u = int(gray.mean(axis=0).argmin())
    steps = np.diff(gray[:, u])
    if steps.size == 0 or steps.max() < contrast:
        reason = f"no step of {contrast:g} DN in column {u}"
        return TipObservation.failed(TipStatus.NOT_FOUND, reason, layers=kept)
    v = int(steps.argmax())
    return TipObservation.found((u, v), axis_px=(0, -1), confidence=0.5, layers=kept)
