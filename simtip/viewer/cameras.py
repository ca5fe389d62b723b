"""Cameras with their images."""

from __future__ import annotations

import numpy as np
import rerun as rr

from simtip.camera import StereoRig
from simtip.export.eight_bit import eight_bit
from simtip.geometry import Array, Pose
from simtip.image_sets.pairs import SIDES
from simtip.sensor import Image
from simtip.viewer.paths import camera_of, image_of

HALF_PX = 0.5
"""Rerun counts pixels from the corner of the first one, simtip from its centre."""

PLANE_MM = 60.0
"""How far from its camera an image is drawn in space."""


def log_cameras(
    recording: rr.RecordingStream, rig: StereoRig, images: tuple[Image, Image], bit_depth: int
) -> None:
    """Record both cameras as pinholes: distortion is in the images, and not in the frusta."""
    poses = Pose.identity(), rig.T_lr
    for side, camera, T_wc, image in zip(SIDES, (rig.left, rig.right), poses, images, strict=True):
        recording.log(camera_of(side), rr.Transform3D(translation=T_wc.t, mat3x3=T_wc.R))
        K = camera.K + np.array([[0, 0, HALF_PX], [0, 0, HALF_PX], [0, 0, 0]])
        recording.log(
            image_of(side),
            rr.Pinhole(
                image_from_camera=K,
                width=camera.width,
                height=camera.height,
                camera_xyz=rr.ViewCoordinates.RDF,
                image_plane_distance=PLANE_MM,
            ),
        )
        recording.log(f"{image_of(side)}/rgb", rr.Image(eight_bit(image, bit_depth)))


def log_pixels(
    recording: rr.RecordingStream, side: str, name: str, places_px: Array, colour: list[int]
) -> None:
    """Record points (n, 2) px of an image; n may be 0."""
    points = rr.Points2D(np.reshape(places_px, (-1, 2)) + HALF_PX, colors=[colour], radii=-3.0)
    recording.log(f"{image_of(side)}/{name}", points)
