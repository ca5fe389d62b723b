"""The Cramer-Rao bound: how well a scene's images allow its tip to be measured, by any method.

`tip_bound` works it out from renders, their derivatives with respect to the needle's pose, and the
sensor's noise; docs/bound.md says what is in it.
"""

from simtip.bound.information import Information
from simtip.bound.inputs import bound_digests
from simtip.bound.known import KnownBound
from simtip.bound.maps import InformationMap
from simtip.bound.ratio import efficiency, pooled_efficiency
from simtip.bound.reading import reading_information
from simtip.bound.result import NUISANCES, TipBound, ViewBound
from simtip.bound.tip import SAMPLES, tip_bound

__all__ = [
    "NUISANCES",
    "SAMPLES",
    "Information",
    "InformationMap",
    "KnownBound",
    "TipBound",
    "ViewBound",
    "bound_digests",
    "efficiency",
    "pooled_efficiency",
    "reading_information",
    "tip_bound",
]
