"""A view's light groups on disk: one multi-layer OpenEXR file, enough to go on from.

The file has four parts, all of the same frame:

``light``
    ``lamp.<name>.R/G/B``, radiance per unit radiance of each lamp, and ``ambient.R/G/B`` likewise.
``scene``
    ``mask.needle`` and ``mask.clutter``, 0 to 1, and ``Z``, camera z in mm.
``noise``
    ``noise.<group>``, its Monte-Carlo standard deviation where a pixel was not sampled on its own.
``sampled``
    ``samples`` per pixel (0: not sampled on its own) and ``covariance.<i>.<j>`` of groups i <= j
    where it is not 0; only the window around those pixels.

Light and noise are not compressed: their low bits are as good as random, so packing them would save
little and cost more time than all the rest of a remix. Recompressing the file without loss changes
nothing; what is lossy or damaged is noticed.

The attribute ``simtip`` of the first part holds JSON: the format, the version, the side, the seed,
the back end, the whole scene, and the CRC-32 of every channel's bytes, row by row.
"""

from simtip.light_file.heading import ATTRIBUTE, FORMAT
from simtip.light_file.lights import Lights, lights_name, read_lights, write_lights

__all__ = ["ATTRIBUTE", "FORMAT", "Lights", "lights_name", "read_lights", "write_lights"]
