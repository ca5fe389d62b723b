"""simtip: synthetic-rendering validation for stereo needle-tip measurement.

The whole road in two calls::

    import simtip

    scene = simtip.load_scene("scenes/01_single_tip.yaml")
    trial = simtip.run_trial(scene)
    print(trial.measurement.tip_mm, trial.error.point)

`simulate` and `measure_pair` are its two halves; the second works on images of any origin.
Importing simtip loads neither Mitsuba nor Dr.Jit: the first render does. What else it takes is
loaded when it is first asked for.

PYTEST_DONT_REWRITE: who runs pytest from a program that has imported simtip shall not be warned.
"""

from importlib import import_module

from simtip.version import __version__

# Not typing's own, whose import takes longer than all else here.
TYPE_CHECKING = False

if TYPE_CHECKING:
    from simtip.camera import Camera, StereoRig
    from simtip.detect import TipObservation, configure
    from simtip.errors import BackendError, InputError, SimtipError
    from simtip.geometry import Pose
    from simtip.image_file import read_image, write_png
    from simtip.measure import Measurement, measure_pair
    from simtip.render import View, render_pair
    from simtip.rig_file import read_rig, write_rig
    from simtip.scene_file import dump_scene, load_scene, scene_schema
    from simtip.score import TipError
    from simtip.simulation import Simulation, simulate
    from simtip.spec import SceneSpec
    from simtip.trial import Trial, run_trial
    from simtip.truth import SceneTruth, scene_truth

__all__ = [
    "BackendError",
    "Camera",
    "InputError",
    "Measurement",
    "Pose",
    "SceneSpec",
    "SceneTruth",
    "SimtipError",
    "Simulation",
    "StereoRig",
    "TipError",
    "TipObservation",
    "Trial",
    "View",
    "__version__",
    "configure",
    "dump_scene",
    "load_scene",
    "measure_pair",
    "read_image",
    "read_rig",
    "render_pair",
    "run_trial",
    "scene_schema",
    "scene_truth",
    "simulate",
    "write_png",
    "write_rig",
]

_HOMES = {
    "Camera": "camera",
    "StereoRig": "camera",
    "TipObservation": "detect",
    "configure": "detect",
    "BackendError": "errors",
    "InputError": "errors",
    "SimtipError": "errors",
    "Pose": "geometry",
    "read_image": "image_file",
    "write_png": "image_file",
    "Measurement": "measure",
    "measure_pair": "measure",
    "View": "render",
    "render_pair": "render",
    "read_rig": "rig_file",
    "write_rig": "rig_file",
    "dump_scene": "scene_file",
    "load_scene": "scene_file",
    "scene_schema": "scene_file",
    "TipError": "score",
    "Simulation": "simulation",
    "simulate": "simulation",
    "SceneSpec": "spec",
    "Trial": "trial",
    "run_trial": "trial",
    "SceneTruth": "truth",
    "scene_truth": "truth",
}
"""The module in which each public name is."""

if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        """Load what is asked for: a public name, or a module of simtip."""
        if name in _HOMES:
            value = getattr(import_module(f"simtip.{_HOMES[name]}"), name)
            globals()[name] = value
            return value
        if not name.startswith("_"):
            try:
                return import_module(f"simtip.{name}")
            except ModuleNotFoundError as error:
                if error.name != f"simtip.{name}":
                    raise
        raise AttributeError(f"module 'simtip' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
