"""The rig that a scene's images are measured with: the true one, or a calibration's."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from simtip.errors import InputError
from simtip.rig_file import read_rig

if TYPE_CHECKING:
    from simtip.camera import Camera, StereoRig
    from simtip.spec import CameraSpec, SceneSpec

FIELD = "rig.measured"


def measuring_rig(spec: SceneSpec) -> StereoRig:
    """Give the rig that measures.

    Parameters
    ----------
    spec
        The scene. `rig.measured` names a file in any format of `simtip.rig_file`, for the whole
        sensors or for what is read out of them; its left camera's frame is taken for the world.

    Raises
    ------
    InputError
        The file cannot be read, or is for images of another size; it names the file.
    """
    true = spec.rig.rig()
    path = spec.rig.measured
    if path is None:
        return true
    whole = spec.rig.left.camera(whole=True).size, spec.rig.right.camera(whole=True).size
    return read_out(read_rig(path, *whole), spec, path)


def read_out(rig: StereoRig, spec: SceneSpec, path: str) -> StereoRig:
    """Give a rig of a scene's whole sensors, or of what is read out of them, for the latter.

    Parameters
    ----------
    rig
        The rig.
    spec
        The scene.
    path
        Where it is from, for messages.

    Raises
    ------
    InputError
        It is for images of another size.
    """
    left, right = (
        _cropped(side, camera, spec_of, path)
        for side, camera, spec_of in (
            ("left", rig.left, spec.rig.left),
            ("right", rig.right, spec.rig.right),
        )
    )
    return replace(rig, left=left, right=right)


def _cropped(side: str, camera: Camera, seen: CameraSpec, path: str) -> Camera:
    wanted, whole = seen.camera().size, (seen.width, seen.height)
    if camera.size == wanted:
        return camera
    if camera.size == whole and seen.roi is not None:
        return camera.cropped(*seen.roi)
    width, height = camera.size
    raise InputError(
        f"is for {side} images of {width}x{height} px, and the scene's have "
        f"{wanted[0]}x{wanted[1]} px",
        file=path,
        field=f"{FIELD}: image size",
        remedy="calibrate with images of this camera",
    )
