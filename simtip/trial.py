"""One scene, one seed, one scored measurement: where simulation and measurement meet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simtip.detect import ConfiguredDetector, configure, parameters_of
from simtip.measure import Measurement, measure_pair
from simtip.measuring_rig import measuring_rig
from simtip.render import Backend, Progress
from simtip.score import PixelError, TipError, score_tip
from simtip.simulation import Simulation, simulate
from simtip.spec import SceneSpec


@dataclass(frozen=True, eq=False)
class Trial:
    """A simulated pair, what was measured on it, and how wrong that is."""

    simulation: Simulation
    measurement: Measurement
    error: TipError

    @property
    def ok(self) -> bool:
        """Whether a tip was measured."""
        return self.measurement.status == "ok"

    def to_dict(self) -> dict[str, Any]:
        """Give plain lists and numbers: the keys of ``run --json``."""
        simulation, truth, point = self.simulation, self.simulation.truth, self.error.point
        measured = self.measurement.to_dict()
        return {
            "scene": simulation.spec.name,
            "seed": simulation.seed,
            "backend": simulation.backend.variant,
            "detector": simulation.spec.detect.name,
            "rig_measured": simulation.spec.rig.measured,
            **measured,
            "tip_true_mm": truth.tip_mm.tolist(),
            "error_mm": point
            and {"x": point.x_mm, "y": point.y_mm, "z": point.z_mm, "norm": point.norm_mm},
            "tip_true_px": {
                "left": truth.left.tip_px.tolist(),
                "right": truth.right.tip_px.tolist(),
            },
            "silhouette_tip_px": {
                "left": truth.left.silhouette_tip_px.tolist(),
                "right": truth.right.silhouette_tip_px.tolist(),
            },
            "error_px": {"left": _pixel(self.error.left), "right": _pixel(self.error.right)},
            "timings_s": {**simulation.timings_s, **measured["timings_s"]},
        }


def _pixel(error: PixelError | None) -> dict[str, float | None] | None:
    if error is None:
        return None
    return {
        "u": error.u_px,
        "v": error.v_px,
        "along": error.along_px,
        "across": error.across_px,
    }


def detector_of(spec: SceneSpec) -> ConfiguredDetector:
    """Configure the detector that the scene names.

    Above 8 bit, a detector that wants to know what is white is told the sensor's top code.

    Raises
    ------
    InputError
        There is no such detector or parameter, or a value does not fit; `field` begins with
        ``detect``.
    """
    values = spec.detect.parameters()
    declared = {parameter.name for parameter in parameters_of(spec.detect.name)}
    if spec.sensor.bit_depth > 8 and "full_scale" in declared:
        values.setdefault("full_scale", 2**spec.sensor.bit_depth - 1)
    return configure(spec.detect.name, values)


def run_trial(
    spec: SceneSpec,
    *,
    seed: int | None = None,
    backend: Backend | None = None,
    progress: Progress | None = None,
    detector: ConfiguredDetector | None = None,
) -> Trial:
    """Simulate a scene, measure the tip on its images, score it against the truth.

    `detector` is any callable from an image to a `TipObservation`, in place of the scene's own. The
    other parameters and errors are those of `simtip.simulation.simulate` and `detector_of`. A tip
    that is not found is no error but a result with its reason. The images are measured with the rig
    that `rig.measured` names, if it names one; the error is still that against the truth.
    """
    detector = detector or detector_of(spec)
    rig = measuring_rig(spec)
    simulation = simulate(spec, seed=seed, backend=backend, progress=progress)
    truth = simulation.truth
    measurement = measure_pair(
        *simulation.images,
        rig,
        detector,
        max_distance_px=spec.match.max_distance_px,
        method=spec.triangulate.method,
    )
    error = score_tip(
        point_measured_mm=measurement.tip_mm,
        point_true_mm=truth.tip_mm,
        tips_measured_px=(measurement.left.tip_px, measurement.right.tip_px),
        tips_true_px=(truth.left.tip_px, truth.right.tip_px),
        axes_true_px=(truth.left.axis_px, truth.right.axis_px),
    )
    return Trial(simulation, measurement, error)
