"""The causes of error that can be switched off, or set to their true value."""

from __future__ import annotations

from enum import StrEnum

from simtip.spec import SceneSpec


class Cause(StrEnum):
    """A cause of error; what it is without it stands in `WITHOUT`."""

    QUANTISATION = "pixel quantisation"
    RECESSION = "tip recession"
    MISMATCH = "mismatch of the views"
    NOISE = "noise"
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
    Cause.DEFOCUS: "a pinhole's sharpness, with the diffraction and aberration that the lens has",
    Cause.DISTORTION: "a lens model that can hold the lens's distortion",
    Cause.CALIBRATION: "the rig as it is, or as a calibration without noise would find it",
    Cause.REFERENCE: "displacements held against the needle's true ones",
}
"""What it is like when a cause is off."""


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
    if all(lens.focus_mm is None for lens in lenses):
        absent[Cause.DEFOCUS] = "both cameras are pinholes (rig.left.lens.focus_mm)"
    if how is None or how.distortion != "none":
        absent[Cause.DISTORTION] = "the lens model holds it (experiment.calibration.distortion)"
    elif not any(any(lens.distortion) for lens in lenses):
        absent[Cause.DISTORTION] = "the lenses have none"
    if how is None and not measured:
        absent[Cause.CALIBRATION] = "the true rig measures (experiment.calibration, rig.measured)"
    return [cause for cause in Cause if cause not in absent], absent
