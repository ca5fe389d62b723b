"""From two images to one point in space: detection, matching, triangulation, refinement.

Knows nothing of the simulation, so it works on photographs.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from simtip.camera import Camera, StereoRig
from simtip.detect import ConfiguredDetector, Image, TipObservation
from simtip.detect.protocol import for_camera
from simtip.detect.region import Region, within
from simtip.errors import InputError
from simtip.geometry import Array
from simtip.match import MAX_DISTANCE_PX, StereoMatch, match_tips
from simtip.refine.refinement import Refinement, Refiner
from simtip.refine.regions import inside
from simtip.triangulate import Method, TipEstimate, triangulate


@dataclass(frozen=True, eq=False)
class Measurement:
    """Everything measured on one pair of images; a stage that could not run is None.

    Attributes
    ----------
    left, right
        What the detector saw.
    match
        Whether the two tips can be one point.
    estimate
        The tip in the rig's frame, triangulated.
    refinement
        The tip from both images at once, the needle's shape known; None if that was not asked for
        or nothing was triangulated.
    timings_s
        Wall time of "detect", "match", "triangulate" and, if asked for, "refine"; 0 for what did
        not run.
    """

    left: TipObservation
    right: TipObservation
    match: StereoMatch | None = None
    estimate: TipEstimate | None = None
    refinement: Refinement | None = None
    timings_s: dict[str, float] = field(default_factory=dict)

    @property
    def status(self) -> str:
        """``ok`` or the code of the first thing that failed, e.g. ``left_touches_border``."""
        for side, seen in (("left", self.left), ("right", self.right)):
            if not seen.ok:
                return f"{side}_{seen.status}"
        for stage in (self.match, self.estimate):
            if stage is not None and not stage.ok:
                return str(stage.status)
        return "ok"

    @property
    def reason(self) -> str:
        """What failed, in a sentence with its numbers; empty if nothing did."""
        views = [(f"{side}: ", seen) for side, seen in (("left", self.left), ("right", self.right))]
        stages = [("", stage) for stage in (self.match, self.estimate) if stage is not None]
        return "; ".join(
            f"{where}{part.reason}" for where, part in [*views, *stages] if not part.ok
        )

    @property
    def tip_mm(self) -> Array | None:
        """The measured tip (3,), mm, rig frame: the refined one if there is, else the triangulated.

        None if there is none.
        """
        if self.refinement is not None and self.refinement.ok:
            return self.refinement.tip_mm
        return None if self.estimate is None else self.estimate.point_mm

    @property
    def covariance_mm2(self) -> Array | None:
        """Covariance (3, 3) of `tip_mm`, mm^2, as claimed; None if there is none."""
        if self.refinement is not None and self.refinement.ok:
            return self.refinement.covariance_mm2
        return None if self.estimate is None else self.estimate.covariance_mm2

    def to_dict(self) -> dict[str, Any]:
        """Give plain lists and numbers: the keys of ``measure --json``."""
        return {
            "status": self.status,
            "reason": self.reason,
            "tip_measured_mm": _plain(self.tip_mm),
            "tip_covariance_mm2": _plain(self.covariance_mm2),
            "tip_triangulated_mm": _plain(
                None if self.estimate is None else self.estimate.point_mm
            ),
            "refined": None if self.refinement is None else self.refinement.to_dict(),
            "tip_detected_px": {
                "left": _plain(self.left.tip_px),
                "right": _plain(self.right.tip_px),
            },
            "epipolar_distance_px": self.match and self.match.distance_px,
            "ray_gap_mm": self.estimate and self.estimate.gap_mm,
            "timings_s": dict(self.timings_s),
        }


def _plain(values: Array | None) -> Any:
    return None if values is None else values.tolist()


@contextmanager
def timed(timings_s: dict[str, float], name: str) -> Iterator[None]:
    """Record the wall time of a block."""
    start = time.perf_counter()
    yield
    timings_s[name] = time.perf_counter() - start


def require_size(
    side: str,
    image: Image,
    camera: Camera,
    *,
    file: str | Path | None = None,
    remedy: str = "give the rig that took the images",
) -> None:
    """Refuse an image that this camera did not take.

    Parameters
    ----------
    side
        "left" or "right", for the message.
    image
        (H, W) or (H, W, 3).
    camera
        Of that side of the rig.
    file, remedy
        For the message: where the image is from, and what to do.

    Raises
    ------
    InputError
        The image is not of the camera's size.
    """
    height, width = image.shape[:2]
    if (width, height) != camera.size:
        raise InputError(
            f"the {side} image is {width}x{height} px, but the rig's {side} camera "
            f"{camera.width}x{camera.height}",
            file=file,
            remedy=remedy,
        )


def _seen(side: str, image: Image, detector: ConfiguredDetector) -> TipObservation:
    try:
        return detector(image)
    except InputError as error:  # a setting that does not suit the image
        raise InputError(
            f"for the {side} image: {error.problem}", field=error.field, remedy=error.remedy
        ) from error


def _looking(
    detector: ConfiguredDetector, camera: Camera, region: Region | None
) -> ConfiguredDetector:
    """Give the detector for one camera's images, or a region of them."""
    if region is None:
        return for_camera(detector, camera)
    seen = camera.cropped(region.u0, region.v0, region.width, region.height)
    return within(for_camera(detector, seen), region, of_whole=False)


def measure_pair(
    left: Image,
    right: Image,
    rig: StereoRig,
    detector: ConfiguredDetector,
    *,
    max_distance_px: float = MAX_DISTANCE_PX,
    method: Method = "svd",
    regions: tuple[Region | None, Region | None] = (None, None),
    refiner: Refiner | None = None,
) -> Measurement:
    """Measure the needle tip on one pair of images.

    Parameters
    ----------
    left, right
        (H, W) gray or (H, W, 3) RGB, 8 or 16 bit, of the sizes that the rig says.
    rig
        The calibrated cameras.
    detector
        See `simtip.detect.configure`.
    max_distance_px
        Largest accepted symmetric epipolar distance.
    method
        Of triangulation; see `simtip.triangulate`.
    regions
        Where to look in the left and in the right image; None is everywhere. Results are in
        pixels of the whole images.
    refiner
        What refines the tip once it is triangulated, e.g. `simtip.refine.silhouette` of the
        needle's shape. It looks in the same regions.

    Raises
    ------
    InputError
        An image is not of the size that the rig says, or a region or a setting of the detector
        does not suit it.
    """
    require_size("left", left, rig.left)
    require_size("right", right, rig.right)
    timings = dict.fromkeys(("detect", "match", "triangulate"), 0.0)
    with timed(timings, "detect"):
        seen = (
            _seen("left", left, _looking(detector, rig.left, regions[0])),
            _seen("right", right, _looking(detector, rig.right, regions[1])),
        )
    if seen[0].tip_px is None or seen[1].tip_px is None:
        return Measurement(*seen, timings_s=timings)
    with timed(timings, "match"):
        match = match_tips(seen[0].tip_px, seen[1].tip_px, rig, max_distance_px)
    if not match.ok:
        return Measurement(*seen, match, timings_s=timings)
    covariances = [o.covariance_px for o in seen]
    claimed = all(c is not None for c in covariances)
    with timed(timings, "triangulate"):
        estimate = triangulate(
            seen[0].tip_px,
            seen[1].tip_px,
            rig,
            method,
            covariance_left_px=covariances[0] if claimed else None,
            covariance_right_px=covariances[1] if claimed else None,
        )
    if refiner is None or not estimate.ok:
        return Measurement(*seen, match, estimate, timings_s=timings)
    with timed(timings, "refine"):
        refinement = inside(refiner, regions)(left, right, rig)
    return Measurement(*seen, match, estimate, refinement, timings)
