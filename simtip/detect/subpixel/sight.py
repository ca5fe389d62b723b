"""How a needle stands to the line of sight, from its picture and the camera's focal length.

A shaft of even thickness looks the narrower the farther it is, so its width tells its slope in
depth.
"""

from __future__ import annotations

import numpy as np

from simtip.detect.subpixel.shaft import Shaft
from simtip.geometry import Array, unit

STEEPEST = 0.9


def tilt(shaft: Shaft, v: float, focal_px: float, centre: Array) -> float:
    """Give the sine of the axis, towards the hub, along the line of sight to it at row v.

    Parameters
    ----------
    shaft
        In the turned image.
    v
        Row there.
    focal_px
        Focal length.
    centre
        (2,) principal point in the turned image.
    """
    at = np.array(v)
    u, slope = float(shaft.axis_u(at)), float(shaft.slope(at))
    step = 0.5 * shaft.scale
    widths = shaft.half_px(np.array([v - step, v]))
    farther = -(np.log(widths[1]) - np.log(widths[0])) / step  # change of depth, relative, per row
    ray = np.array([(u - centre[0]) / focal_px, (v - centre[1]) / focal_px, 1.0])
    down = farther * ray + np.array([slope, 1.0, 0.0]) / focal_px
    return float(np.clip(-unit(down) @ unit(ray), -STEEPEST, STEEPEST))
