"""What is tried: detectors with matching and triangulation, and the refinement of both images."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from numpy.typing import NDArray

from simtip import InputError, SceneSpec, configure
from simtip.camera import Camera
from simtip.geometry import Array
from simtip.measure import Measurement, measure_pair
from simtip.refine import Refinement
from simtip.spec.scene import RefineSpec
from simtip.trial import refiner_of

Images: TypeAlias = tuple[NDArray[Any], NDArray[Any]]

SILHOUETTE = "silhouette"


@dataclass(frozen=True, eq=False)
class Claim:
    """What a method says of one image: the status, the tip (2,) px and its covariance (2, 2) px^2.

    The last two are None where it says nothing.
    """

    status: str
    tip_px: Array | None
    covariance_px: Array | None


@dataclass(frozen=True, eq=False)
class Answer:
    """What a method says of a pair.

    Attributes
    ----------
    views
        Left and right.
    tip_mm, covariance_mm2
        (3,) and (3, 3), the rig's frame, mm; None where it says nothing.
    time_s
        What it took.
    of_both
        Whether it looks at both images at once: what it says of one is then the tip in space,
        projected.
    """

    views: tuple[Claim, Claim]
    tip_mm: Array | None
    covariance_mm2: Array | None
    time_s: float
    of_both: bool = False


Measure: TypeAlias = Callable[[Images], Answer]
Method: TypeAlias = Callable[[SceneSpec], Measure]
"""Sets itself up for a scene, or raises `NotForThisError`."""


class NotForThisError(Exception):
    """The method is not for such a needle."""


def methods_of(names: list[str]) -> dict[str, Method]:
    """Give methods by name: `SILHOUETTE`, or what names a detector."""
    return {
        name: silhouette_method() if name == SILHOUETTE else detector_method(name) for name in names
    }


def detector_method(reference: str) -> Method:
    """Make a method of a detector, with its default parameters, matching and triangulation."""
    detect = configure(reference)

    def method(scene: SceneSpec) -> Measure:
        rig = scene.rig.rig()

        def measure(images: Images) -> Answer:
            return _of_measurement(
                measure_pair(
                    *images,
                    rig,
                    detect,
                    max_distance_px=scene.match.max_distance_px,
                    method=scene.triangulate.method,
                )
            )

        return measure

    return method


def silhouette_method() -> Method:
    """Make a method of the stereo refinement, the scene's needle known.

    It starts from a detection of its own, by `subpixel`, which its time counts.
    """

    def method(scene: SceneSpec) -> Measure:
        rig = scene.rig.rig()
        asked = scene.model_copy(update={"refine": RefineSpec(name="silhouette")})
        try:
            refiner = refiner_of(asked)
        except InputError as error:
            raise NotForThisError(str(error)) from error
        if refiner is None:
            raise RuntimeError("a scene that asks for a refinement has one")

        def measure(images: Images) -> Answer:
            start = time.perf_counter()
            found = refiner(*images, rig)
            return _of_refinement(found, (rig.left, rig.right), time.perf_counter() - start)

        return measure

    return method


def _of_measurement(seen: Measurement) -> Answer:
    claims = [
        Claim(str(one.status), one.tip_px, one.covariance_px) for one in (seen.left, seen.right)
    ]
    taken = sum(seen.timings_s.values())
    return Answer((claims[0], claims[1]), seen.tip_mm, seen.covariance_mm2, taken)


def _of_refinement(found: Refinement, cameras: tuple[Camera, Camera], taken: float) -> Answer:
    tips = (None, None) if found.tips_px is None else found.tips_px
    # A place whose image lies outside the picture claims no tip in it.
    claims = [
        Claim(str(found.status), tip if tip is not None and camera.contains(tip) else None, None)
        for tip, camera in zip(tips, cameras, strict=True)
    ]
    return Answer((claims[0], claims[1]), found.tip_mm, found.covariance_mm2, taken, of_both=True)
