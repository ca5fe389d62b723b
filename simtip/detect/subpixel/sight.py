"""How a needle stands to the line of sight, from its picture and the camera's focal length.

A shaft of even thickness looks the narrower the farther it is, so its width tells its slope in
depth.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simtip.detect.subpixel.shaft import Shaft
from simtip.geometry import Array, unit

STEEPEST = 0.9

STEP_PX = 1e-3


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
    return _tilt(shaft, shaft.width, v, focal_px, centre)


def tilt_deviation(shaft: Shaft, v: float, focal_px: float, centre: Array) -> float:
    """Give the tilt's deviation, from that of the shaft's width."""
    first, count = len(shaft.axis), len(shaft.width)
    covariance = shaft.covariance[first : first + count, first : first + count]
    by_width = np.zeros(count)
    for k in range(count):
        step = np.zeros(count)
        step[k] = STEP_PX
        more, less = (
            _tilt(shaft, shaft.width + sign * step, v, focal_px, centre) for sign in (1, -1)
        )
        by_width[k] = (more - less) / (2 * STEP_PX)
    return float(np.sqrt(max(float(by_width @ covariance @ by_width), 0.0)))


def _tilt(shaft: Shaft, width: Array, v: float, focal_px: float, centre: Array) -> float:
    shaft = replace(shaft, width=width)
    at = np.array(v)
    u, slope = float(shaft.axis_u(at)), float(shaft.slope(at))
    step = 0.5 * shaft.scale
    widths = shaft.half_px(np.array([v - step, v]))
    farther = -(np.log(widths[1]) - np.log(widths[0])) / step  # change of depth, relative, per row
    ray = np.array([(u - centre[0]) / focal_px, (v - centre[1]) / focal_px, 1.0])
    down = farther * ray + np.array([slope, 1.0, 0.0]) / focal_px
    return float(np.clip(-unit(down) @ unit(ray), -STEEPEST, STEEPEST))
