"""Run the measurement on something that takes frames."""

from __future__ import annotations

from simtip.emva.evaluate import Series, characterise
from simtip.emva.frames import average, summarise
from simtip.emva.plan import Capture, Plan
from simtip.emva.result import CameraCharacteristics


def measure_camera(capture: Capture, plan: Plan) -> CameraCharacteristics:
    """Take all series of the plan and evaluate them by `simtip.emva.characterise`.

    Memory is a few frames, whatever the plan.

    Raises
    ------
    InputError
        The frames are not raw frames of one channel, size and bit depth, or too few came.
    """
    bits, exposure = plan.bit_depth, plan.exposure_s
    flats = tuple(
        average(
            capture(photons, exposure, plan.flat_frames),
            photons=photons,
            exposure_s=exposure,
            bit_depth=bits,
        )
        for photons in plan.flat_photons
    )
    transfer = tuple(
        summarise(
            capture(photons, exposure, plan.frames),
            photons=photons,
            exposure_s=exposure,
            bit_depth=bits,
        )
        for photons in plan.photons
    )
    dark = tuple(
        summarise(
            capture(plan.dark_photons, exposure_s, plan.frames),
            photons=plan.dark_photons,
            exposure_s=exposure_s,
            bit_depth=bits,
        )
        for exposure_s in plan.dark_exposures_s
    )
    # The flats are levels too, and of many frames.
    series = Series((*transfer, *(flat.level for flat in flats)), dark, flats)
    return characterise(series, bit_depth=bits, photons_absolute=plan.photons_absolute)
