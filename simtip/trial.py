"""One scene, one seed, one scored measurement: where simulation and measurement meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from simtip.bound import KnownBound, efficiency
from simtip.camera import StereoRig
from simtip.detect import ConfiguredDetector, configure, names_code, parameters_of
from simtip.detect.excerpt import excerpt
from simtip.errors import InputError
from simtip.geometry import Array
from simtip.measure import Measurement, measure_pair
from simtip.measuring_rig import measuring_rig
from simtip.refine import Refiner, Solid, silhouette
from simtip.render import Backend, Progress
from simtip.score import PixelError, TipError, point_error, score_tip
from simtip.sensor import Image
from simtip.simulation import Simulation, simulate
from simtip.spec import SceneSpec
from simtip.spec.scene import DetectSpec
from simtip.truth import SceneTruth


@dataclass(frozen=True, eq=False)
class Trial:
    """A simulated pair, what was measured on it, and how wrong that is.

    Attributes
    ----------
    simulation, measurement
        The pair, and what was measured on it.
    error
        Of `Measurement.tip_mm`, and of the tip in both images.
    bound
        The least error that any method can have on this scene, if it is known.
    """

    simulation: Simulation
    measurement: Measurement
    error: TipError
    bound: KnownBound | None = None

    @property
    def ok(self) -> bool:
        """Whether a tip was measured."""
        return self.measurement.status == "ok"

    @property
    def errors_mm(self) -> dict[str, float | None]:
        """Norm of the error in space of every result, mm; None for what there is not."""
        estimate, refinement = self.measurement.estimate, self.measurement.refinement
        true_mm = self.simulation.truth.tip_mm
        return {
            "triangulated": _error_mm(None if estimate is None else estimate.point_mm, true_mm),
            "refined": _error_mm(None if refinement is None else refinement.tip_mm, true_mm),
        }

    def efficiency(self) -> dict[str, float | None] | None:
        """Give the bound, mm, and bound / error of every result; None without a bound.

        With one trial the error stands for the RMSE: by luck it may be below the bound. Over many,
        see `simtip.bound.pooled_efficiency` of `errors_mm`.
        """
        if self.bound is None:
            return None
        bound_mm = self.bound.norm_mm
        ratios = {name: efficiency(bound_mm, error) for name, error in self.errors_mm.items()}
        return {"bound_mm": bound_mm, **ratios}

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
            "efficiency": self.efficiency(),
            "timings_s": {**simulation.timings_s, **measured["timings_s"]},
        }


def _error_mm(place_mm: Array | None, true_mm: Array) -> float | None:
    error = point_error(place_mm, true_mm)
    return None if error is None else error.norm_mm


def _pixel(error: PixelError | None) -> dict[str, float | None] | None:
    if error is None:
        return None
    return {
        "u": error.u_px,
        "v": error.v_px,
        "along": error.along_px,
        "across": error.across_px,
    }


def detector_of(spec: SceneSpec, allowed: str | None = None) -> ConfiguredDetector:
    """Configure the detector that the scene names.

    Above 8 bit, a detector that wants to know what is white is told the sensor's top code.

    Parameters
    ----------
    spec
        The scene.
    allowed
        A program or module that the caller is willing to run. A scene is data, often somebody
        else's: it may name a built-in detector or an installed plug-in, but ``cmd:...`` and
        ``module:function``, dithered or not, only if they are equal to this.

    Raises
    ------
    InputError
        There is no such detector or parameter, a value does not fit, or the scene names code that
        is not allowed; `field` begins with ``detect``.
    """
    name = spec.detect.name
    if name != allowed and names_code(name):
        raise InputError(
            f"a scene may not start a program or import a module by itself ({excerpt(name)})",
            field="detect.name",
            remedy="if you trust it, say the same by --detector, or as run_trial(detector=...)",
        )
    values = spec.detect.parameters()
    declared = {parameter.name for parameter in parameters_of(name)}
    if spec.sensor.bit_depth > 8 and "full_scale" in declared:
        values.setdefault("full_scale", 2**spec.sensor.bit_depth - 1)
    return configure(name, values)


def with_detector(
    spec: SceneSpec, reference: str | None, settings: Mapping[str, object] | None = None
) -> SceneSpec:
    """Give the scene with another detector, or other parameters of its own.

    Parameters
    ----------
    spec
        The scene.
    reference
        Which detector (see `simtip.detect.get`); None is the scene's own. The scene's parameters
        are kept if it is the same one.
    settings
        Parameters in place of the scene's.
    """
    name = spec.detect.name if reference is None else reference
    kept = spec.detect.parameters() if name == spec.detect.name else {}
    values: dict[str, Any] = {**kept, **(settings or {}), "name": name}
    return spec.model_copy(update={"detect": DetectSpec.model_validate(values)})


def refiner_of(spec: SceneSpec) -> Refiner | None:
    """Set up the refinement that the scene asks for: of its own needle, the shape known.

    Raises
    ------
    InputError
        The needle is none that can be refined; `field` is ``refine.name``.
    """
    if spec.refine.name == "none":
        return None
    needle = spec.needle.needle()
    try:
        solid = Solid.from_mesh(*needle.surface(), needle.apex)
    except InputError as error:
        raise InputError(
            f"the needle {error.problem}",
            field="refine.name",
            remedy="write none, or take a straight, convex needle",
        ) from error
    depth = spec.sensor.bit_depth
    return silhouette(solid, 2**depth - 1 if depth > 8 else None)


def run_trial(
    spec: SceneSpec,
    *,
    seed: int | None = None,
    backend: Backend | None = None,
    progress: Progress | None = None,
    detector: ConfiguredDetector | str | None = None,
    bound: KnownBound | None = None,
    noise_seed: int | None = None,
    light: SceneSpec | None = None,
) -> Trial:
    """Simulate a scene, measure the tip on its images, score it against the truth.

    `detector` is any callable from an image to a `TipObservation`, in place of the scene's own, or
    names one as `simtip.detect.get` takes it: only so does a program or a module run that the scene
    names, too. The other parameters and errors are those of `simtip.simulation.simulate` and
    `detector_of`. A tip that is not found is no error but a result with its reason. The images are
    measured with the rig that `rig.measured` names, if it names one; the error is still that
    against the truth.

    With `bound` the trial tells its efficiency. A bound of another scene or seed than this is
    refused before anything is rendered (`KnownBound.require_scene`).
    """
    if bound is not None:
        bound.require_scene(spec, seed)
    if detector is None or isinstance(detector, str):
        spec = with_detector(spec, detector)
        detector = detector_of(spec, allowed=detector)
    refiner = refiner_of(spec)
    rig = measuring_rig(spec)
    simulation = simulate(
        spec, seed=seed, backend=backend, progress=progress, noise_seed=noise_seed, light=light
    )
    measurement, error = measured(
        simulation.images, simulation.truth, spec, detector, rig=rig, refiner=refiner
    )
    return Trial(simulation, measurement, error, bound)


def measured(
    images: tuple[Image, Image],
    truth: SceneTruth,
    spec: SceneSpec,
    detector: ConfiguredDetector,
    *,
    rig: StereoRig,
    refiner: Refiner | None,
) -> tuple[Measurement, TipError]:
    """Measure the tip on a pair of images and score it.

    Parameters
    ----------
    images, truth
        Left and right, DN, and what is true of them.
    spec
        Says how to match and to triangulate.
    detector, rig, refiner
        What measures.
    """
    measurement = measure_pair(
        *images,
        rig,
        detector,
        max_distance_px=spec.match.max_distance_px,
        method=spec.triangulate.method,
        refiner=refiner,
    )
    error = score_tip(
        point_measured_mm=measurement.tip_mm,
        point_true_mm=truth.tip_mm,
        tips_measured_px=(measurement.left.tip_px, measurement.right.tip_px),
        tips_true_px=(truth.left.tip_px, truth.right.tip_px),
        axes_true_px=(truth.left.axis_px, truth.right.axis_px),
    )
    return measurement, error
