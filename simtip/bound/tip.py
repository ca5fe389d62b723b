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
from simtip.bound.inputs import bound_digests
from simtip.bound.maps import information_map
from simtip.bound.pose import PLACE, STEP_PX, VIEW_POSE, ViewMoves
from simtip.bound.result import TipBound, ViewBound
from simtip.geometry import Array
from simtip.noise_budget import SIDES, Side
from simtip.render import Backend, Progress, choose, movable_needle
from simtip.simulation import expose_pair
from simtip.spec import SceneSpec
from simtip.truth import scene_truth

if TYPE_CHECKING:
    from simtip.render.moved import MovableNeedle

SAMPLES = 256
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
    step_px: float = STEP_PX,
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
    step_px
        How far the central differences move the needle's edges in the image, about.
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
    sampled = spec.render.model_copy(update={"noise": None, "samples": VIEW_SAMPLES})
    plain = spec.model_copy(update={"render": sampled})
    moves = {side: ViewMoves.of(truth, side) for side in SIDES}
    with movable_needle(plain, backend=backend, seed=seed) as needle:
        settled = expose_pair(plain, needle.views, seed=seed, backend=backend).spec
        seen = [
            watch(settled, moves[side], needle, side, samples)
            for side, view in zip(SIDES, needle.views, strict=True)
            if view.coverage.any()
        ]
        work = _Work(progress, seen, check=check)
        told = {
            each.side: _told(needle, each, moves[each.side], work, step_px, check=check)
            for each in seen
        }
    views = {side: told[side].bound if side in told else _unseen(moves[side]) for side in SIDES}
    bound = TipBound(
        scene=spec.name,
        seed=seed,
        backend=backend.variant,
        inputs_sha256=bound_digests(spec, seed),
        step_px=step_px,
        step_mm=moves["left"].step_mm(step_px),
        samples=samples,
        replicas=REPLICAS,
        views=views,
        axes=moves["left"].axes,
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
        looks = 1 + 2 * len(VIEW_POSE) * (2 if check else 1)
        once = sum(int(each.effort.samples.sum()) * each.replicas for each in watched)
        self._total = once * looks
        self._progress, self._done = progress, 0

    def add(self, samples: int) -> None:
        self._done += samples
        if self._progress is not None:
            self._progress(self._done / self._total)


def watch(
    spec: SceneSpec, moves: ViewMoves, needle: MovableNeedle, side: Side, samples: int
) -> Watched:
    """Choose what to look at in one view, and how closely; the needle is in it.

    Parameters
    ----------
    spec
        The scene, its exposure settled.
    moves
        How the needle moves in this view.
    needle
        What is looked at.
    side
        Which view.
    samples
        Of a pixel at the needle's edge, all replicas together.
    """
    view = needle.views[SIDES.index(side)]
    band = needle.band(side)
    each = effort_for(band, view.coverage, TipZone.of(moves, spec), samples, REPLICAS)
    return Watched(side, band, each, REPLICAS, Picture(spec, side, view, band))


def _told(
    needle: MovableNeedle,
    watched: Watched,
    moves: ViewMoves,
    work: _Work,
    step_px: float,
    *,
    check: bool,
) -> _Told:
    """Find out what a view tells."""
    derivatives = Derivatives(needle, watched, moves, work.add)
    picture, side = watched.picture, watched.side
    names = (*VIEW_POSE, *(f"{side}_{name}" for name in APPEARANCE))
    told_by = picture.information(derivatives.irradiance)[picture.touched]

    def gathered(by_pose: Array) -> Information:
        every = np.concatenate([by_pose, derivatives.appearance[: len(by_pose)]], axis=1)
        return Information.from_derivatives(
            names, every.reshape(*every.shape[:2], -1), told_by.reshape(-1)
        )

    by_pose = derivatives.pose(step_px)
    variants = {"half_samples": gathered(by_pose[: REPLICAS // 2])}
    if check:
        variants["half_step"] = gathered(derivatives.pose(step_px / 2))
    where = information_map(by_pose, told_by, moves, picture, derivatives.irradiance)
    return _Told(ViewBound(gathered(by_pose), moves, where), variants)


def _unseen(moves: ViewMoves) -> ViewBound:
    """Give what a view without the needle tells: nothing, about any parameter of the pose."""
    nothing = np.zeros((len(VIEW_POSE), len(VIEW_POSE)))
    return ViewBound(Information(VIEW_POSE, nothing, nothing), moves, None)


def _convergence(bound: TipBound, told: dict[Side, _Told], names: list[str]) -> dict[str, Any]:
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
    signal, noise = np.diag(every.matrix), np.diag(every.noise)
    share = np.divide(noise, signal, out=np.full(len(signal), np.inf), where=signal > 0)
    found["noise_share"] = dict(zip(PLACE, share.tolist(), strict=True))
    return found
