"""Pictures on which one sees at a glance whether a detected needle tip is right.

Plain arrays in, plain arrays out; nothing of the simulation or of the detectors is needed. A point
is (u, v) with pixel (0, 0) at the centre of the top-left pixel, here as everywhere.
"""

from simtip.overlay.layer import layer_picture
from simtip.overlay.view import draw_view, side_by_side

__all__ = ["draw_view", "layer_picture", "side_by_side"]
