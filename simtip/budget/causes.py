"""The causes of error that can be switched off, or set to their true value."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

from simtip.spec import SceneSpec


class Cause(StrEnum):
    """A cause of error; what it is without it stands in `WITHOUT`."""

    QUANTISATION = "pixel quantisation"
    RECESSION = "tip recession"
    MISMATCH = "mismatch of the views"
    NOISE = "noise"
    RIPPLE = "ripple of the lamps"
    DEFOCUS = "defocus"
    DISTORTION = "distortion ignored"
    CALIBRATION = "calibration"
    REFERENCE = "stage and reference"


WITHOUT = {
    Cause.QUANTISATION: "the detector's answer averaged over images shifted by parts of a pixel",
    Cause.RECESSION: (
        "both views' apparent tips (noise-free, unquantised) moved by one length along the needle, "
        "so that they are at the true tip on average"
    ),
    Cause.MISMATCH: "what then remains between apparent and true tip in each view taken away",
    Cause.NOISE: "no temporal noise of the sensor (photons, dark current, read-out)",
    Cause.RIPPLE: "every pair of images begins at the same moment of the mains",
    Cause.DEFOCUS: "a pinhole's sharpness, with the light, diffraction and aberration of the lens",
    Cause.DISTORTION: "a lens model that can hold the lens's distortion",
    Cause.CALIBRATION: "the rig as it is, or as a calibration without noise would find it",
    Cause.REFERENCE: "displacements held against the needle's true ones",
}
"""What it is like when a cause is off."""


HELD: dict[str, set[int]] = {
    "none": set(),
    "radial2": {0, 1},
    "radtan": {0, 1, 2, 3},
    "opencv5": {0, 1, 2, 3, 4},
    "rational": {0, 1, 2, 3, 4, 5, 6, 7},
}
"""Which of OpenCV's coefficients k1 k2 p1 p2 k3 k4 k5 k6 a lens model has."""


def _used(scene: SceneSpec) -> set[int]:
    """Give which coefficients of distortion the scene's lenses have."""
    lenses = (scene.rig.left.lens, scene.rig.right.lens)
    return {k for lens in lenses for k, value in enumerate(lens.distortion) if value}


def holding(scene: SceneSpec) -> Literal["opencv5", "rational"]:
    """Name a lens model that holds the distortion of the scene's lenses."""
    return "opencv5" if _used(scene) <= HELD["opencv5"] else "rational"


def ripples(scene: SceneSpec) -> bool:
    """Say whether images differ by the moment at which they begin."""
    jitter = scene.experiment.schedule.start_jitter_s
    return jitter > 0 and any(lamp.ballast.ripples for lamp in scene.lamps)


def present(scene: SceneSpec, *, whole_pixels: bool) -> tuple[list[Cause], dict[Cause, str]]:
    """Tell which causes a scene has.

    Parameters
    ----------
    scene
        With its experiment.
    whole_pixels
        Whether the detector answers in whole pixels.

    Returns
    -------
    causes
        Those that it has.
    absent
        Why it has none of the others.
    """
    how = scene.experiment.calibration
    measured = scene.rig.measured is not None
    lenses = (scene.rig.left.lens, scene.rig.right.lens)
    absent: dict[Cause, str] = {}
    if not whole_pixels:
        absent[Cause.QUANTISATION] = "the detector answers in parts of a pixel"
    if not scene.sensor.noise:
        absent[Cause.NOISE] = "the sensor has none (sensor.noise)"
    if not scene.experiment.schedule.start_jitter_s:
        absent[Cause.RIPPLE] = "all images begin at the same moment (schedule.start_jitter_s)"
    elif not any(lamp.ballast.ripples for lamp in scene.lamps):
        absent[Cause.RIPPLE] = "no lamp ripples (lamps[0].ballast)"
    if all(lens.focus_mm is None for lens in lenses):
        absent[Cause.DEFOCUS] = "both cameras are pinholes (rig.left.lens.focus_mm)"
    if how is None or how.distortion == "auto" or _used(scene) <= HELD[how.distortion]:
        absent[Cause.DISTORTION] = "the lens model holds it (experiment.calibration.distortion)"
        if not _used(scene):
            absent[Cause.DISTORTION] = "the lenses have none"
    if how is None and not measured:
        absent[Cause.CALIBRATION] = "the true rig measures (experiment.calibration, rig.measured)"
    return [cause for cause in Cause if cause not in absent], absent
