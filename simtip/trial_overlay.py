"""Pictures to judge a trial by: both views with the true and the detected tip."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simtip.overlay import draw_view

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from simtip.measure import Measurement
    from simtip.sensor import Image
    from simtip.spec import SceneSpec
    from simtip.truth import SceneTruth


def trial_overlay(
    images: tuple[Image, Image],
    truth: SceneTruth,
    spec: SceneSpec,
    measurement: Measurement | None = None,
    *,
    name: str | None = None,
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Draw the tips, true and detected, and epipolar lines over both images.

    Parameters
    ----------
    images, truth, spec
        Left and right, DN; what is true of them; the scene, whose sensor says what is white.
    measurement
        What was measured; None if nothing was.
    name
        For the titles; by default the scene's.

    Returns
    -------
    ndarray, ndarray
        Left and right, (H, W, 3) uint8, RGB.
    """
    match = None if measurement is None else measurement.match
    lines = (None, None) if match is None else (match.line_left, match.line_right)
    seen = (None, None) if measurement is None else (measurement.left, measurement.right)
    left, right = (
        draw_view(
            image,
            title=f"{spec.name if name is None else name}: {side}",
            tip_true_px=view.tip_px,
            tip_detected_px=None if found is None else found.tip_px,
            epipolar_line=line,
            axis_px=view.axis_px,
            reason=(found.reason or None) if found is not None else None,
            white_dn=2**spec.sensor.bit_depth - 1,
        )
        for side, image, view, found, line in zip(
            ("left", "right"), images, (truth.left, truth.right), seen, lines, strict=True
        )
    )
    return left, right
