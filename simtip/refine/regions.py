"""Refine within regions of the images."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.detect.protocol import Image
from simtip.detect.region import Region
from simtip.geometry import Array
from simtip.refine.refinement import Refinement, Refiner


def inside(refiner: Refiner, regions: tuple[Region | None, Region | None]) -> Refiner:
    """Let a refinement see regions alone, as cameras that read out no more; None is all.

    Tips count in pixels of the whole images.

    Raises
    ------
    InputError
        By the refinement that is given: a region reaches outside of its image.
    """

    def refine(left: Image, right: Image, rig: StereoRig) -> Refinement:
        one, other = regions
        seen, camera = _read_out(left, rig.left, one)
        seen_right, camera_right = _read_out(right, rig.right, other)
        found = refiner(seen, seen_right, replace(rig, left=camera, right=camera_right))
        if found.tips_px is None:
            return found
        return replace(found, tips_px=found.tips_px + np.stack([_corner(one), _corner(other)]))

    return refine


def _read_out(image: Image, camera: Camera, region: Region | None) -> tuple[Image, Camera]:
    if region is None:
        return image, camera
    region.check(image.shape)
    u, v, width, height = region.u0, region.v0, region.width, region.height
    return image[v : v + height, u : u + width], camera.cropped(u, v, width, height)


def _corner(region: Region | None) -> Array:
    return np.zeros(2) if region is None else np.array([region.u0, region.v0], np.float64)
