"""The sub-pixel detector: shaft and tip fitted to the picture, with a covariance.

Nothing in it is a threshold on the tip, so the tip does not recede with light, blur or noise: edges
are where the model of the whole picture has them. The steps are `bands` (what may be a needle),
`trace` (its rows), `shaft_fit` (axis, width, blur) and `tip` (the outline of its end).
"""

from __future__ import annotations

import numpy as np

from simtip.detect.observation import Layers, TipObservation
from simtip.detect.protocol import FunctionDetector, Image
from simtip.detect.subpixel.analysis import Analysis, analyse
from simtip.detect.subpixel.no_needle import NoNeedleError
from simtip.detect.subpixel.parameters import DEFAULTS, SubpixelParameters


def detect(
    image: Image, parameters: SubpixelParameters = DEFAULTS, *, layers: bool = False
) -> TipObservation:
    """Measure the needle tip in one picture.

    Parameters
    ----------
    image
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16. Not changed.
    parameters
        See there.
    layers
        Keep ``tip_seen`` and ``tip_fitted``, the picture around the tip and the fit to it, and
        ``tip_residual``, 128 plus four times the difference; all turned so that the tip points
        down. Saturated pixels, which do not count, and those next to them are white.

    Returns
    -------
    TipObservation
        With axis and covariance.

    Raises
    ------
    InputError
        The array is no image of a supported kind.
    """
    try:
        found = analyse(image, parameters)
    except NoNeedleError as error:
        return TipObservation.failed(error.status, error.reason)
    return TipObservation.found(
        found.tip_px,
        axis_px=found.axis_px,
        covariance_px=found.covariance_px,
        layers=_layers(found) if layers else {},
    )


def _layers(found: Analysis) -> Layers:
    window = found.scenery.window
    shape = window.shape
    seen = found.scenery.value.reshape(shape)
    residual = found.tip.residual.reshape(shape)
    pictures = {
        "tip_seen": seen,
        "tip_fitted": seen - residual,
        "tip_residual": 128 + 4 * residual,
    }
    return {
        name: np.clip(np.rint(picture), 0, 255).astype(np.uint8)
        for name, picture in pictures.items()
    }


DETECTOR = FunctionDetector(
    name="subpixel",
    summary="Both flanks and the tip's outline fitted to the picture; with covariance",
    parameters_type=SubpixelParameters,
    function=detect,
)
