"""Needle-tip detection: an image in, a tip or the reason why there is none out."""

from simtip.detect.observation import TipObservation, TipStatus
from simtip.detect.parameters import DetectorParameters, Parameter
from simtip.detect.protocol import ConfiguredDetector, Detector, FunctionDetector, Image
from simtip.detect.registry import configure, get, names, parameters_of

__all__ = [
    "ConfiguredDetector",
    "Detector",
    "DetectorParameters",
    "FunctionDetector",
    "Image",
    "Parameter",
    "TipObservation",
    "TipStatus",
    "configure",
    "get",
    "names",
    "parameters_of",
]
