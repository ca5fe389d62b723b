"""Stereo refinement: a needle of known shape fitted to both pictures at once.

`refine` starts from what `simtip.detect.subpixel` finds in each picture. The needle is a `Solid`:
any straight, convex mesh (`Solid.from_mesh`, `read_solid`), or one named by two figures (`named`).
"""

from simtip.refine.generate import named
from simtip.refine.refinement import Refinement, Refiner, RefineStatus, refine, silhouette
from simtip.refine.solid import Solid
from simtip.refine.solid_file import read_solid, solid_of

__all__ = [
    "RefineStatus",
    "Refinement",
    "Refiner",
    "Solid",
    "named",
    "read_solid",
    "refine",
    "silhouette",
    "solid_of",
]
