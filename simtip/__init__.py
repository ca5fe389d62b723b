"""simtip: synthetic-rendering validation for stereo needle-tip measurement.

The whole road in two calls::

    import simtip

    scene = simtip.load_scene("scenes/01_single_tip.yaml")
    trial = simtip.run_trial(scene)
    print(trial.measurement.tip_mm, trial.error.point)

`simulate` and `measure_pair` are its two halves; the second works on images of any origin.
Importing simtip loads neither Mitsuba nor Dr.Jit: the first render does.
"""

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
from simtip.version import __version__

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
