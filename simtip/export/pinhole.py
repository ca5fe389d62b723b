"""Images of a lens with distortion as a pinhole would have taken them."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from simtip.camera import Camera, StereoRig
from simtip.geometry import Array
from simtip.sensor import Image

Mask = NDArray[np.bool_]


def without_distortion(rig: StereoRig) -> StereoRig:
    """Give the rig with the same K, sizes and pose, and no distortion."""
    left, right = (replace(camera, distortion=()) for camera in (rig.left, rig.right))
    return replace(rig, left=left, right=right)


def undistorted(image: Image, camera: Camera) -> tuple[Image, Mask]:
    """Resample an image as the camera without its distortion would have taken it.

    Linear between the four nearest pixel centres, rounded: noise between centres is smoothed.
    (OpenCV's `remap` would round places to 1/32 px.)

    Parameters
    ----------
    image
        (H, W, 3).
    camera
        That took it.

    Returns
    -------
    image, known
        The new image of the same size, 0 where the old one does not reach; (H, W) where it does.
    """
    if not camera.distortion:
        return image, np.ones(image.shape[:2], np.bool_)
    places = _sources(camera)
    height, width = image.shape[:2]
    with np.errstate(invalid="ignore"):
        inside = (places >= 0) & (places <= [width - 1, height - 1])
    known = np.asarray(inside.all(axis=-1))
    v, u = np.where(known, places[..., 1], 0), np.where(known, places[..., 0], 0)
    channels = [
        ndimage.map_coordinates(image[..., k].astype(np.float64), [v, u], order=1)
        for k in range(image.shape[2])
    ]
    made = np.rint(np.stack(channels, axis=-1)).astype(image.dtype)
    made[~known] = 0
    return cast("Image", made), known


def _sources(camera: Camera) -> Array:
    """Give where the camera sees what a pinhole sees at each pixel's centre, (H, W, 2)."""
    v, u = np.mgrid[: camera.height, : camera.width].astype(np.float64)
    xy = (np.stack([u, v], axis=-1) - camera.K[:2, 2]) / np.diag(camera.K)[:2]
    return camera.project(np.concatenate([xy, np.ones((*xy.shape[:2], 1))], axis=-1))
