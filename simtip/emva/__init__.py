"""Measure a camera from its own frames, in the terms of EMVA 1288 (release 4.0 linear).

    plan = plan_measurement(capture, bit_depth=8, exposure_s=0.01)
    print(measure_camera(capture, plan).to_dict())

`capture(photons, exposure_s, count)` yields raw frames of one channel; they are pulled one by one
and never kept. Who has frames on disk uses `summarise` and `average` on them, then `characterise`.
What each parameter means, and where it departs from the standard, is in `characterise`.
"""

from __future__ import annotations

from simtip.emva.estimate import Estimate
from simtip.emva.evaluate import Series, characterise
from simtip.emva.frames import Level, MeanFrame, average, summarise
from simtip.emva.measure import measure_camera
from simtip.emva.plan import Capture, Plan, plan_measurement
from simtip.emva.result import CameraCharacteristics

__all__ = [
    "CameraCharacteristics",
    "Capture",
    "Estimate",
    "Level",
    "MeanFrame",
    "Plan",
    "Series",
    "average",
    "characterise",
    "measure_camera",
    "plan_measurement",
    "summarise",
]
