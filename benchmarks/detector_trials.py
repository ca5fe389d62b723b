"""Methods tried on a condition: every observation beside its truth."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from detector_conditions import Condition
from light_cache import rendered
from numpy.typing import NDArray

from simtip import SceneSpec, configure
from simtip.camera import StereoRig
from simtip.detect import TipObservation
from simtip.measure import Measurement, measure_pair
from simtip.render import choose
from simtip.score import pixel_error, point_error
from simtip.seeding import seed32
from simtip.simulation import expose_pair
from simtip.truth import SceneTruth, ViewTruth

Images: TypeAlias = tuple[NDArray[Any], NDArray[Any]]
Method: TypeAlias = Callable[[Images, StereoRig, SceneSpec], Measurement]
"""Anything that measures a pair: a detector with what follows it, or a method of both images."""


@dataclass(frozen=True)
class Look:
    """What a method said of one image.

    Attributes
    ----------
    pose
        Which of the condition's scenes it was, and which side: fresh noise alone tells equal ones
        apart.
    in_view
        Whether the true tip lies in the image.
    status
        Of the observation.
    along_px, across_px
        Error against the apex; None without a tip.
    width_px
        The needle's width at the tip.
    claimed_px2
        Claimed variance along and across; None if none is claimed.
    """

    pose: str
    in_view: bool
    status: str
    along_px: float | None
    across_px: float | None
    width_px: float
    claimed_px2: tuple[float, float] | None


@dataclass(frozen=True)
class Try:
    """One pair: both looks, the error's norm in space (None without a tip) and the time taken."""

    looks: tuple[Look, Look]
    error_mm: float | None
    time_s: float


def detector_method(reference: str) -> Method:
    """Make a method of a detector, with its default parameters, matching and triangulation."""
    detect = configure(reference)

    def measure(images: Images, rig: StereoRig, scene: SceneSpec) -> Measurement:
        return measure_pair(
            *images,
            rig,
            detect,
            max_distance_px=scene.match.max_distance_px,
            method=scene.triangulate.method,
        )

    return measure


def tries(
    condition: Condition, methods: Mapping[str, Method], cache: Path | None = None
) -> Iterator[tuple[str, Try]]:
    """Render each scene once, expose it anew as often as asked, and let every method measure it.

    All methods see the same images; the noise depends on the condition's name alone. `cache` is a
    folder in which rendered light is kept.
    """
    backend = choose()
    for number, scene in enumerate(condition.scenes()):
        views = rendered(scene, backend, cache)
        rig = scene.rig.rig()
        for exposure in range(condition.exposures):
            seed = seed32(zlib.crc32(condition.name.encode()), "exposure", number, exposure)
            shot = expose_pair(scene, views, seed=seed, backend=backend, light_seed=scene.seed)
            images = shot.images
            if condition.stored is not None:
                images = (condition.stored(images[0]), condition.stored(images[1]))
            for name, method in methods.items():
                yield name, _judged(number, scene, shot.truth, method(images, rig, scene))


def _judged(number: int, scene: SceneSpec, truth: SceneTruth, seen: Measurement) -> Try:
    rig = scene.rig.rig()
    depth_mm = scene.needle.tip_mm[2]
    looks = []
    for side, observation, camera in (
        ("left", seen.left, rig.left),
        ("right", seen.right, rig.right),
    ):
        view = getattr(truth, side)
        width_px = camera.K[0, 0] * scene.needle.diameter_mm / depth_mm
        in_view = bool(camera.contains(view.tip_px))
        looks.append(_look(f"{number} {side}", observation, view, width_px, in_view=in_view))
    error = point_error(seen.tip_mm, truth.tip_mm)
    return Try((looks[0], looks[1]), error and error.norm_mm, sum(seen.timings_s.values()))


def _look(
    pose: str, seen: TipObservation, view: ViewTruth, width_px: float, *, in_view: bool
) -> Look:
    error = pixel_error(seen.tip_px, view.tip_px, view.axis_px)
    claimed = None
    if seen.covariance_px is not None:
        along = view.axis_px
        frame = np.array([along, [-along[1], along[0]]])
        variances = np.diag(frame @ seen.covariance_px @ frame.T)
        claimed = (float(variances[0]), float(variances[1]))
    along_px, across_px = (None, None) if error is None else (error.along_px, error.across_px)
    return Look(pose, in_view, str(seen.status), along_px, across_px, float(width_px), claimed)
