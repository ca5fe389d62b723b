"""The sub-pixel detector, a room for each of its steps."""

from simtip.detect.subpixel.detector import DETECTOR, detect
from simtip.detect.subpixel.parameters import SubpixelParameters

__all__ = ["DETECTOR", "SubpixelParameters", "detect"]
