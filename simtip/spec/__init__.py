"""The scene, as data: strict, frozen models of what a scene file may say.

World frame = left camera frame (x right, y down, z forward), millimetres. Loading from YAML, with
errors that name the line, is in `simtip.scene_file`.
"""

from simtip.spec.background import BackgroundSpec
from simtip.spec.clutter import ClutterSpec
from simtip.spec.lamps import LampSpec, PanelLamp, PointLamp, TrofferLamp
from simtip.spec.light import AmbientSpec, Ballast, Lamp, TubeLamp
from simtip.spec.material import NeedleMaterial
from simtip.spec.needle import (
    BackBevelTip,
    BevelTip,
    BluntTip,
    ConeTip,
    DiamondTip,
    FranseenTip,
    LancetTip,
    NeedleSpec,
    TrocarTip,
)
from simtip.spec.recalibration import RecalibrationSpec
from simtip.spec.rig import CameraSpec, LensSpec, RigSpec
from simtip.spec.room import RoomSpec
from simtip.spec.scene import DetectSpec, MatchSpec, RenderSpec, SceneSpec, TriangulateSpec
from simtip.spec.sensor import EffectsSpec, SensorSpec

__all__ = [
    "AmbientSpec",
    "BackBevelTip",
    "BackgroundSpec",
    "Ballast",
    "BevelTip",
    "BluntTip",
    "CameraSpec",
    "ClutterSpec",
    "ConeTip",
    "DetectSpec",
    "DiamondTip",
    "EffectsSpec",
    "FranseenTip",
    "Lamp",
    "LampSpec",
    "LancetTip",
    "LensSpec",
    "MatchSpec",
    "NeedleMaterial",
    "NeedleSpec",
    "PanelLamp",
    "PointLamp",
    "RecalibrationSpec",
    "RenderSpec",
    "RigSpec",
    "RoomSpec",
    "SceneSpec",
    "SensorSpec",
    "TriangulateSpec",
    "TrocarTip",
    "TrofferLamp",
    "TubeLamp",
]
