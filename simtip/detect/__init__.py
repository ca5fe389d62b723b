"""Needle-tip detection: an image in, a tip or the reason why there is none out."""

from simtip.detect.observation import TipObservation, TipStatus
from simtip.detect.parameters import DetectorParameters, Parameter
from simtip.detect.protocol import ConfiguredDetector, Detector, FunctionDetector, Image
from simtip.detect.region import Region, parse_region
from simtip.detect.registry import (
    Listing,
    catalogue,
    configure,
    get,
    listing,
    names,
    names_code,
    parameters_of,
)

__all__ = [
    "ConfiguredDetector",
    "Detector",
    "DetectorParameters",
    "FunctionDetector",
    "Image",
    "Listing",
    "Parameter",
    "Region",
    "TipObservation",
    "TipStatus",
    "catalogue",
    "configure",
    "get",
    "listing",
    "names",
    "names_code",
    "parameters_of",
    "parse_region",
]
