"""The scene, as data: strict, frozen models of what a scene file may say.

World frame = left camera frame (x right, y down, z forward), millimetres. Loading from YAML, with
errors that name the line, is in `simtip.scene_file`.
"""

from simtip.spec.background import BackgroundSpec
from simtip.spec.light import AmbientSpec, TubeLamp
from simtip.spec.material import NeedleMaterial
from simtip.spec.needle import BevelTip, ConeTip, NeedleSpec
from simtip.spec.rig import CameraSpec, LensSpec, RigSpec
from simtip.spec.scene import DetectSpec, MatchSpec, RenderSpec, SceneSpec, TriangulateSpec
from simtip.spec.sensor import EffectsSpec, SensorSpec

__all__ = [
    "AmbientSpec",
    "BackgroundSpec",
    "BevelTip",
    "CameraSpec",
    "ConeTip",
    "DetectSpec",
    "EffectsSpec",
    "LensSpec",
    "MatchSpec",
    "NeedleMaterial",
    "NeedleSpec",
    "RenderSpec",
    "RigSpec",
    "SceneSpec",
    "SensorSpec",
    "TriangulateSpec",
    "TubeLamp",
]
