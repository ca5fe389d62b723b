"""Pairs of images with rig, needle, tips and rays, to look at in Rerun.

The only part of simtip that loads ``rerun``, and only when something is recorded.
"""

from simtip.viewer.show import Destination, show

__all__ = ["Destination", "show"]
