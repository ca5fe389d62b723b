"""What is true of a scene: where the tip is, in space and in both images.

World frame = left camera frame, mm. Whatever makes the truth meaningless, a tip behind a camera
or a needle that no camera sees, is the user's error and is reported as such.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from simtip.errors import InputError
from simtip.footprint import in_view
from simtip.geometry import Array, Pose, unit
from simtip.needle import Needle
from simtip.silhouette import apex_is_hidden, projected_axis, silhouette_tip

if TYPE_CHECKING:
    from simtip.camera import Camera, StereoRig
    from simtip.spec import BackgroundSpec, SceneSpec


@dataclass(frozen=True, eq=False)
class ViewTruth:
    """What is true in one image.

    Attributes
    ----------
    tip_px
        (2,) projection of the apex, also where it lies outside the image.
    silhouette_tip_px
        (2,) foremost point of the needle's image along `axis_px`: what a detector can at best
        see of a bevelled tip. Outside the image, too, if it lies there.
    axis_px
        (2,) unit direction in the image from the tip to the hub, at the tip.
    tip_visible
        The apex lies in the image and the needle's own body does not hide it.
    needle_in_view
        Some part of the needle lies in the image.
    """

    tip_px: Array
    silhouette_tip_px: Array
    axis_px: Array
    tip_visible: bool
    needle_in_view: bool


@dataclass(frozen=True, eq=False)
class SceneTruth:
    """What is true of a scene.

    Attributes
    ----------
    tip_mm
        (3,) the apex, world.
    axis
        (3,) unit direction from the tip to the hub, world; of a bent needle the tangent at the tip.
    left, right
        What is true in each image.
    rig
        The cameras, cropped to their regions of interest as the images are.
    needle
        The needle's geometry.
    T_wn
        Maps the needle's frame to the world.
    """

    tip_mm: Array
    axis: Array
    left: ViewTruth
    right: ViewTruth
    rig: StereoRig
    needle: Needle
    T_wn: Pose

    def to_dict(self) -> dict[str, Any]:
        """Give plain lists, numbers and texts, for ``truth.json``."""
        needle = self.needle
        return {
            "world": "left camera frame, mm: x right, y down, z forward",
            "pixels": "(u, v), u right, v down; (0, 0) is the centre of the top-left pixel",
            "tip_mm": self.tip_mm.tolist(),
            "axis": self.axis.tolist(),
            "needle": {
                "diameter_mm": float(needle.diameter_mm),
                "length_mm": float(needle.length_mm),
                "bend_radius_mm": _or_none(needle.bend_radius_mm),
                "bend_direction_deg": float(needle.bend_direction_deg),
                "tip": {"kind": needle.tip.kind, **_parameters(needle)},
                "equally_foremost_mm": self.T_wn.apply(needle.apexes[1:]).tolist(),
                "T_wn": _pose(self.T_wn),
            },
            "left": _view(self.left, self.rig.left),
            "right": _view(self.right, self.rig.right),
            "T_lr": _pose(self.rig.T_lr),
        }


def scene_truth(spec: SceneSpec) -> SceneTruth:
    """Work out the truth of a scene.

    The background counts as an endless plane here.

    Parameters
    ----------
    spec
        The scene.

    Raises
    ------
    InputError
        With `field`, without file and line: the tip is not in front of both cameras, the needle
        is outside both images or points straight at a camera, or the needle or a camera is
        behind the background.
    """
    rig = spec.rig.rig()
    needle = spec.needle.needle()
    axis = _unit("needle.axis", spec.needle.axis)
    T_wn = needle.pose(spec.needle.tip_mm, axis, spec.needle.roll_deg)
    tip_mm = T_wn.apply(needle.apex)
    views = {
        "left": (rig.left, Pose.identity()),
        "right": (rig.right, rig.T_lr.inverse()),
    }
    for name, (_, T_cw) in views.items():
        _require_before_camera(name, T_cw.apply(tip_mm))
        _require_outside_needle(name, needle, (T_cw @ T_wn).inverse().t)
    _require_before_background(spec.background, needle, T_wn, rig.T_lr.t)
    left, right = (
        _view_truth(name, needle, T_cw @ T_wn, camera) for name, (camera, T_cw) in views.items()
    )
    if not (left.needle_in_view or right.needle_in_view):
        raise InputError(
            f"the needle is outside both images; its tip would be at {_px(left)} px of the left"
            f" and {_px(right)} px of the right one",
            field="needle.tip_mm",
            remedy="move the needle, or turn it by needle.axis, into a camera's field of view",
        )
    return SceneTruth(tip_mm, axis, left, right, rig, needle, T_wn)


def _require_before_camera(name: str, tip_c: Array) -> None:
    if not tip_c[2] > 0:
        raise InputError(
            f"the tip is behind the {name} camera, at z = {tip_c[2]:g} mm in that camera's frame",
            field="needle.tip_mm",
            remedy="z has to be above 0 in both cameras",
        )


def _require_outside_needle(name: str, needle: Needle, centre_n: Array) -> None:
    if needle.encloses(centre_n):
        raise InputError(
            f"the {name} camera is inside the needle",
            field="needle.tip_mm",
            remedy="move or turn the needle, or make it thinner (diameter_mm)",
        )


def _require_before_background(
    background: BackgroundSpec, needle: Needle, T_wn: Pose, right_centre: Array
) -> None:
    normal = _unit("background.normal", background.normal)

    def height(points: Array) -> Array:
        """Give the distance in front of the plane, mm."""
        above: Array = (points - np.array(background.centre_mm)) @ normal
        return above

    cameras = height(np.stack([np.zeros(3), right_centre]))
    if (cameras <= 0).all():
        raise InputError(
            "both cameras are behind the background",
            field="background.normal",
            remedy="the normal points from the background towards the cameras",
        )
    if (cameras <= 0).any():
        name = "left" if cameras[0] <= 0 else "right"
        raise InputError(
            f"the {name} camera is behind the background",
            field="background.centre_mm",
            remedy="move the background away from the cameras",
        )
    vertices, _ = needle.surface()
    needle_height = height(T_wn.apply(vertices))
    if not needle_height.max() > 0:
        raise InputError(
            "the needle is behind the background",
            field="needle.tip_mm",
            remedy="move the needle towards the cameras, or background.centre_mm away from them",
        )
    if not needle_height.min() > 0:
        tip_in_front = float(height(T_wn.apply(needle.apex)))
        raise InputError(
            f"the needle passes through the background, by {-needle_height.min():.3g} mm;"
            f" the tip is {abs(tip_in_front):.3g} mm"
            f" {'in front of' if tip_in_front > 0 else 'behind'} it",
            field="needle.axis" if tip_in_front > 0 else "needle.tip_mm",
            remedy="move or turn the needle, or move background.centre_mm away from the cameras",
        )


def _view_truth(name: str, needle: Needle, T_cn: Pose, camera: Camera) -> ViewTruth:
    try:
        axis_px = projected_axis(needle, T_cn, camera)
    except ValueError as error:
        raise InputError(
            f"in the {name} view {error}", field="needle.axis", remedy="turn the needle"
        ) from error
    tip_px = camera.project(T_cn.apply(needle.apex))
    return ViewTruth(
        tip_px=tip_px,
        silhouette_tip_px=silhouette_tip(needle, T_cn, camera),
        axis_px=axis_px,
        tip_visible=bool(camera.contains(tip_px)) and not apex_is_hidden(needle, T_cn),
        needle_in_view=in_view(needle, T_cn, camera),
    )


def _unit(field: str, vector: tuple[float, float, float]) -> Array:
    try:
        return unit(vector)
    except ValueError as error:  # so long or short that its length is no number
        raise InputError(str(error), field=field, remedy="give a vector of length 1") from error


def _px(view: ViewTruth) -> str:
    u, v = view.tip_px
    return f"({u:.0f}, {v:.0f})"


def _parameters(needle: Needle) -> dict[str, Any]:
    """Give the tip's own parameters: every kind of tip is a dataclass."""
    return {name: float(value) for name, value in asdict(needle.tip).items()}


def _or_none(value: float | None) -> float | None:
    return None if value is None else float(value)


def _pose(pose: Pose) -> dict[str, Any]:
    return {"R": pose.R.tolist(), "t_mm": pose.t.tolist()}


def _view(view: ViewTruth, camera: Camera) -> dict[str, Any]:
    return {
        "tip_px": view.tip_px.tolist(),
        "silhouette_tip_px": view.silhouette_tip_px.tolist(),
        "axis_px": view.axis_px.tolist(),
        "tip_visible": view.tip_visible,
        "needle_in_view": view.needle_in_view,
        "K_px": camera.K.tolist(),
        "distortion": list(camera.distortion),
        "width_px": int(camera.width),
        "height_px": int(camera.height),
    }
