"""The rigs that measure, with and without what a calibration adds to the error."""

from __future__ import annotations

from simtip.budget.causes import Cause, holding
from simtip.budget.errors import Rigs
from simtip.camera import StereoRig
from simtip.experiment.performed import whole_sensors
from simtip.measuring_rig import measuring_rig, read_out
from simtip.recalibration import recalibrated
from simtip.seeding import seed32
from simtip.spec import SceneSpec
from simtip.spec.recalibration import RecalibrationSpec


def rigs_of(scene: SceneSpec, causes: list[Cause], replicates: int, seed: int) -> Rigs:
    """Give the rigs that measure.

    Without the calibration as a cause they are the true one; or, where ignored distortion is one,
    what calibrations without noise make of it. With it, every replicate is a calibration anew.
    """
    true = scene.rig.rig()
    how = scene.experiment.calibration
    if how is None:
        own = [measuring_rig(scene)]
        return {
            (True, True): own,
            (True, False): own,
            (False, True): [true],
            (False, False): [true],
        }
    ideal = how.model_copy(update={"corner_noise_px": 0.0, "print_scale_error": 0.0})
    plate = scene.boards.plate.model_copy(update={"print_scale": (1.0, 1.0), "bow_mm": 0.0})
    boards = scene.boards.model_copy(update={"plate": plate})
    perfect = scene.model_copy(update={"boards": boards})
    if Cause.DISTORTION not in causes:
        noisy = _drawn(scene, how, replicates, seed)
        return {
            (True, True): noisy,
            (True, False): noisy,
            (False, True): [true],
            (False, False): [true],
        }
    return {
        (True, True): _drawn(scene, how, replicates, seed),
        (True, False): _drawn(
            scene, how.model_copy(update={"distortion": holding(scene)}), replicates, seed
        ),
        (False, True): _drawn(perfect, ideal, replicates, seed),
        (False, False): [true],
    }


def _drawn(scene: SceneSpec, how: RecalibrationSpec, replicates: int, seed: int) -> list[StereoRig]:
    """Calibrate again and again; equal replicates of different models share poses and noise."""
    whole = whole_sensors(scene)
    seeds = [seed32(seed, "budget", "calibration", how.seed, k) for k in range(replicates)]
    made = (recalibrated(whole, how.model_copy(update={"seed": one})) for one in seeds)
    return [read_out(rig, scene, "calibration") for rig in made]
