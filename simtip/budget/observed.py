"""The pictures that a budget needs, and where the detector saw the tip in them."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simtip.budget.causes import Cause, ripples
from simtip.errors import InputError
from simtip.experiment.performed import SWEEPS, Said, make_folder
from simtip.experiment.series import START, TIP, Shot, shot_of, zipped_shots
from simtip.geometry import Array
from simtip.seeding import seed32
from simtip.spec import SceneSpec
from simtip.spec.experiment import ExperimentSpec
from simtip.sweep.campaign import Means, carry_out, prepare
from simtip.sweep.plan import Plan
from simtip.sweep.pool import Pool
from simtip.sweep.spec import DetectorEntry, SweepSpec
from simtip.sweep.table import Table

DITHERED = "dithered:"
FOCUS = ("rig.left.lens.focus_mm", "rig.right.lens.focus_mm")
APERTURE = ("rig.left.lens.f_number", "rig.right.lens.f_number")
SIDES = ("left", "right")

ROUNDING_PX = 1e-6
"""Of places that were taken from the true one and are added to it again."""

State = tuple[bool, bool, bool, bool]
"""Whether there are defocus, noise, ripple and quantisation."""


@dataclass(frozen=True, eq=False)
class Observed:
    """Where the tip was seen.

    Attributes
    ----------
    tips_px
        (replicates or 1, places, 2, 2), left and right, u and v, by state; NaN where it was not
        found. States that the scene cannot have are not there.
    whole_pixels
        Whether the detector answers in whole pixels, or halves.
    counts
        How often each stage was worked out now.
    """

    tips_px: Mapping[State, Array]
    whole_pixels: bool
    counts: Counter[str]


@dataclass(frozen=True, eq=False)
class Order:
    """What is to be taken.

    Attributes
    ----------
    scene, seed
        The scene; the root of all random numbers.
    tips_mm
        (places, 3) of the needle's tip, world.
    true_px
        (places, 2, 2) where they are in both images.
    start_s
        (replicates, places) when images begin, if at moments of their own; else None.
    replicates
        Draws of the noise.
    allowed
        A detector that is a program or a module, which the caller is willing to run.
    retry_failed
        Whether measurements that failed are tried again.
    """

    scene: SceneSpec
    seed: int
    tips_mm: Array
    true_px: Array
    start_s: Array | None
    replicates: int
    allowed: tuple[str, ...] = ()
    retry_failed: bool = False


def observe(order: Order, out: Path, means: Means, said: Said = lambda _: None) -> Observed:
    """Take the pictures and look for the tip in them, or go on with it.

    Raises
    ------
    InputError
        The tip was found nowhere without noise, or something cannot be written.
    KeyboardInterrupt
        The same call goes on.
    """
    with closing(means.pool()) as pool:
        return _observed(order, _Work(order, out, means, pool, said))


def _observed(order: Order, work: _Work) -> Observed:
    plain = order.scene.detect.name
    calm = work.done("calm", noise=False, ripple=False, detectors=[plain])
    seen = np.concatenate([tips.ravel() for tips in calm.values()])
    seen = seen[np.isfinite(seen)]
    if not len(seen):
        raise InputError(
            "the tip was found in no image without noise",
            field="detect",
            remedy="see its sweeps by `simtip results`, and try another threshold or light",
        )
    # The mean of a row of pixels may be half of one.
    whole = bool(np.abs(2 * seen - np.round(2 * seen)).max() < ROUNDING_PX)
    both = [plain, DITHERED + plain] if whole else [plain]
    found = dict(calm)
    if whole:
        found |= work.done("calm_dithered", noise=False, ripple=False, detectors=both[1:])
    noises = [False, True] if order.scene.sensor.noise else [False]
    moments = [False] if order.start_s is None else [False, True]
    for noise, ripple in itertools.product(noises, moments):
        if noise or ripple:
            name = "_".join(["noisy"] * noise + ["rippled"] * ripple)
            found |= work.done(name, noise=noise, ripple=ripple, detectors=both)
    return Observed(found, whole, work.counts)


class _Work:
    """Sweeps of a budget, one after the other."""

    def __init__(self, order: Order, out: Path, means: Means, pool: Pool, said: Said) -> None:
        self._order, self._out, self._means, self._said = order, out, means, said
        self._pool = pool
        self.counts: Counter[str] = Counter()

    def done(
        self, name: str, *, noise: bool, ripple: bool, detectors: Sequence[str]
    ) -> dict[State, Array]:
        """Work out a sweep over focus and places, and give the tips by state."""
        shots = self._shots(ripple=ripple)
        plan = self._plan(shots, noise=noise, ripple=ripple, detectors=detectors)
        folder = self._out / SWEEPS / name
        make_folder(folder.parent)
        self._said(f"{name.replace('_', ', ')}: {len(plan)} measurements")
        setup = prepare(plan, self._means)
        tally = carry_out(
            *(plan, setup, folder, self._means),
            retry_failed=self._order.retry_failed,
            shared=self._pool,
        )
        self.counts.update(tally.counts)
        rows = Table.open(folder).by_trial()
        where = {one: divmod(k, len(self._order.tips_mm)) for k, one in enumerate(shots)}
        draws = max(plan.spec.repeats, len(shots) // len(self._order.tips_mm))
        shape = (draws, len(self._order.tips_mm), 2, 2)
        found: dict[State, Array] = {}
        for number in range(len(plan)):
            trial = plan.trial(number)
            dithered = trial.measuring.reference.startswith(DITHERED)
            focus = trial.values.get(FOCUS[0]) is not None or trial.values.get(FOCUS[1]) is not None
            state = (focus, noise, ripple, not dithered)
            tips = found.setdefault(state, np.full(shape, np.nan))
            start = trial.values.get(START, shots[0][1])
            draw, place = where[shot_of(trial.values[TIP], start)]
            tips[max(draw, trial.repeat), place] = _tips(rows[number], self._order.true_px[place])
        return found

    def _shots(self, *, ripple: bool) -> list[Shot]:
        """Give the pairs of images, place by place; with ripple, draw by draw."""
        order = self._order
        if not ripple or order.start_s is None:
            return [shot_of(tip, order.scene.sensor.start_s) for tip in order.tips_mm]
        return [
            shot_of(tip, start)
            for starts in order.start_s
            for tip, start in zip(order.tips_mm, starts, strict=True)
        ]

    def _plan(
        self, shots: Sequence[Shot], *, noise: bool, ripple: bool, detectors: Sequence[str]
    ) -> Plan:
        order = self._order
        scene = order.scene.model_copy(update={"experiment": ExperimentSpec()})
        kept = scene.detect.parameters()
        spec = SweepSpec(
            scene="",
            base={"sensor.noise": noise},
            zipped=[
                zipped_shots(shots),
                focuses(scene),
            ],
            # Each draw of the moment has its own noise as it is.
            repeats=order.replicates if noise and not ripple else 1,
            detectors=[DetectorEntry.model_validate({**kept, "name": one}) for one in detectors],
            seed=seed32(order.seed, "budget", "noise"),
        )
        allowed = tuple(prefix + one for one in order.allowed for prefix in ("", DITHERED))
        return Plan(spec, scene, allowed)


def focuses(scene: SceneSpec) -> dict[str, list[float | None]]:
    """Give the lenses as they are, and sharp: pinholes that gather as much light.

    A lens that is focused near has the working f-number N (1 + m), which counts for light and for
    diffraction; a pinhole's is N.
    """
    found: dict[str, list[float | None]] = {}
    lenses = (scene.rig.left.lens, scene.rig.right.lens)
    blurs = any(lens.focus_mm is not None for lens in lenses)
    for lens, focus, aperture in zip(lenses, FOCUS, APERTURE, strict=True):
        found[focus] = [lens.focus_mm, None] if blurs else [None]
        found[aperture] = [lens.f_number, lens.working_f_number()] if blurs else [lens.f_number]
    return found


def _tips(row: Mapping[str, Any], true_px: Array) -> Array:
    """Give both tips (2, 2) of a row, px; NaN for what was not found."""
    errors = [[row[f"{side}_error_{axis}_px"] for axis in "uv"] for side in SIDES]
    return true_px + np.array(errors, dtype=np.float64)


def state(causes: frozenset[Cause], scene: SceneSpec, *, whole_pixels: bool) -> State:
    """Give the state of the pictures under some causes."""
    focused = [scene.rig.left.lens.focus_mm, scene.rig.right.lens.focus_mm] != [None, None]
    return (
        focused and Cause.DEFOCUS in causes,
        scene.sensor.noise and Cause.NOISE in causes,
        ripples(scene) and Cause.RIPPLE in causes,
        # A detector of sub-pixel answers is asked as it is.
        not whole_pixels or Cause.QUANTISATION in causes,
    )
