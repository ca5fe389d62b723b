"""Finding a calibration target in one image: its points to sub-pixel places, or why there are none.

`find` is all that callers need. Inside: candidates (`saddles`, `blobs`, or OpenCV's markers) are
joined to lattices (`grow`), a lattice is compared with the target's (`match`), and the target's own
ink is laid over each point (`register`).
"""

from simtip.find_target.find import find
from simtip.find_target.outcome import NotFound

__all__ = ["NotFound", "find"]
