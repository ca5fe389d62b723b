"""Stereo refinement: a needle of known shape fitted to both pictures at once."""

from simtip.refine.refinement import Refinement, RefineStatus, refine
from simtip.refine.solid import Solid

__all__ = ["RefineStatus", "Refinement", "Solid", "refine"]
