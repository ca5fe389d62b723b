"""From a scene to the Cramer-Rao bound of its tip's place."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from simtip.bound.derivatives import APPEARANCE, Derivatives, Watched
from simtip.bound.effort import TipZone, effort_for
from simtip.bound.formation import Picture
from simtip.bound.information import Information
from simtip.bound.maps import information_map
from simtip.bound.pose import PLACE, POSE, Axes, Steps, ViewMoves, steps_for
from simtip.bound.result import SIDES, TipBound, ViewBound
from simtip.geometry import Array
from simtip.render import Backend, Progress, choose, movable_needle
from simtip.simulation import expose_pair
from simtip.spec import SceneSpec
from simtip.truth import SceneTruth, scene_truth

if TYPE_CHECKING:
    from simtip.render.moved import MovableNeedle, Side

SAMPLES = 512
"""Of a pixel at the needle's edge, by default."""
REPLICAS = 4
"""Of every derivative; an even number, so that halves can be compared."""
VIEW_SAMPLES = 64
"""Of the views' sampled pixels: for the exposure, and for what lies around the needle."""


def tip_bound(
    spec: SceneSpec,
    *,
    seed: int | None = None,
    backend: Backend | None = None,
    step_mm: float | None = None,
    samples: int = SAMPLES,
    check: bool = True,
    progress: Progress | None = None,
) -> TipBound:
    """Work out the least standard deviation with which a scene's tip can be measured.

    Parameters
    ----------
    spec
        The scene.
    seed
        Root of the Monte-Carlo samples, and of clutter and paper; by default the scene's own.
    backend
        What renders; a vectorised one.
    step_mm
        Of the central differences; by default about 0.02 px (`simtip.bound.pose.STEP_PX`).
    samples
        Of a pixel at the needle's edge, all replicas together.
    check
        Whether the derivatives are taken once more with half the step: twice the time.
    progress
        Called with the fraction done.

    Raises
    ------
    InputError
        The scene has no meaningful truth, no exposure gives `sensor.background_dn`, or the back end
        is scalar.
    """
    start = time.perf_counter()
    seed = spec.seed if seed is None else seed
    truth = scene_truth(spec)
    backend = backend or choose()
    steps = steps_for(truth, step_mm)
    sampled = spec.render.model_copy(update={"noise": None, "samples": VIEW_SAMPLES})
    plain = spec.model_copy(update={"render": sampled})
    with movable_needle(plain, backend=backend, seed=seed) as needle:
        settled = expose_pair(plain, needle.views, seed=seed, backend=backend).spec
        watched = {
            side: _watched(settled, truth, needle, side, samples)
            for side, view in (("left", needle.views[0]), ("right", needle.views[1]))
            if view.coverage.any()
        }
        work = _Work(progress, watched.values(), check=check)
        told = {
            side: _told(Derivatives(needle, each, truth, work.add), each, truth, steps, check=check)
            for side, each in watched.items()
        }
    views = {side: told[side].bound if side in told else _unseen(truth, side) for side in SIDES}
    bound = TipBound(
        scene=spec.name,
        seed=seed,
        backend=backend.variant,
        step_mm=steps.place_mm,
        samples=samples,
        replicas=REPLICAS,
        views=views,
        axes=Axes.of(truth),
    )
    names = sorted({name for each in told.values() for name in each.variants})
    return replace(
        bound,
        convergence=_convergence(bound, told, names),
        timings_s={"bound": time.perf_counter() - start},
    )


@dataclass(frozen=True, eq=False)
class _Told:
    """What a view told, and what it would have told by other settings."""

    bound: ViewBound
    variants: dict[str, Information]


class _Work:
    """Counts samples for a progress bar."""

    def __init__(
        self, progress: Progress | None, watched: Iterable[Watched], *, check: bool
    ) -> None:
        looks = 1 + 2 * len(POSE) * (2 if check else 1)
        self._total = sum(int(each.effort.samples.sum()) * each.replicas * looks for each in watched)
        self._progress, self._done = progress, 0

    def add(self, samples: int) -> None:
        self._done += samples
        if self._progress is not None:
            self._progress(self._done / self._total)


def _watched(
    spec: SceneSpec, truth: SceneTruth, needle: MovableNeedle, side: Side, samples: int
) -> Watched:
    view = needle.views[SIDES.index(side)]
    band = needle.band(side)
    zone = TipZone.of(truth, side)
    each = effort_for(band, view.coverage, zone, samples, REPLICAS)
    return Watched(side, band, each, REPLICAS, Picture(spec, side, view, band))


def _told(
    derivatives: Derivatives, watched: Watched, truth: SceneTruth, steps: Steps, *, check: bool
) -> _Told:
    picture, side = watched.picture, watched.side
    names = (*POSE, *(f"{side}_{name}" for name in APPEARANCE))
    told_by = picture.information(derivatives.irradiance)[picture.touched]

    def gathered(by_pose: Array) -> Information:
        every = np.concatenate([by_pose, derivatives.appearance[: len(by_pose)]], axis=1)
        return Information.from_derivatives(
            names, every.reshape(*every.shape[:2], -1), told_by.reshape(-1)
        )

    by_pose = derivatives.pose(steps)
    variants = {"half_samples": gathered(by_pose[: REPLICAS // 2])}
    if check:
        variants["half_step"] = gathered(derivatives.pose(steps.halved()))
    moves = ViewMoves.of(truth, side)
    picture_map = information_map(
        by_pose[:, : len(PLACE)] , told_by, moves, picture, derivatives.irradiance
    )
    return _Told(ViewBound(gathered(by_pose), moves, picture_map), variants)


def _unseen(truth: SceneTruth, side: str) -> ViewBound:
    """Give what a view without the needle tells: nothing, about any parameter of the pose."""
    nothing = np.zeros((len(POSE), len(POSE)))
    return ViewBound(Information(POSE, nothing, nothing), ViewMoves.of(truth, side), None)


def _convergence(bound: TipBound, told: dict[str, _Told], names: list[str]) -> dict[str, Any]:
    """Compare the bound with what other settings give."""
    found: dict[str, Any] = {}
    norm = bound.place_mm()["norm"]
    for name in names:
        views = {
            side: replace(view, information=told[side].variants[name]) if side in told else view
            for side, view in bound.views.items()
        }
        found[name] = replace(bound, views=views).place_mm()["norm"] / norm
    every = bound.information.of(PLACE)
    share = np.diag(every.noise) / np.diag(every.matrix)
    found["noise_share"] = dict(zip(PLACE, share.tolist(), strict=True))
    return found
