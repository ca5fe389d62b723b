"""A budget from its scene to its result."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simtip.budget.causes import WITHOUT, Cause, present, ripples
from simtip.budget.errors import FROM_START, POSITION, STEP, Errors, Truth
from simtip.budget.observed import Order, observe
from simtip.budget.rigs import rigs_of
from simtip.budget.shares import Shares, rank, split
from simtip.errors import InputError
from simtip.experiment.interferometer import readings
from simtip.experiment.performed import Said, begin, refuse_strangers
from simtip.experiment.series import ACCURACY, Series, series_of, shot_of
from simtip.geometry import Array, unit
from simtip.output_folder import write_atomically
from simtip.seeding import stream
from simtip.spec import SceneSpec
from simtip.sweep.campaign import Means
from simtip.sweep.resuming import alone

RESULT, MADE_BY = "budget.json", "simtip budget"
REPLICATES = 5
LEAST = 4
"""Of positions, or of displacements, that a budget takes."""


@dataclass(frozen=True, eq=False)
class Budget:
    """An error budget.

    Attributes
    ----------
    scene, seed
        What was tried, and the root of its random numbers.
    causes, absent
        What the scene has, in the order of the shares; why it has none of the others.
    shares
        Of mean square errors, mm^2, by kind: "position", "step", "from_start".
    recession_mm
        (places,) how far along the needle the tip is seen with all causes but noise and
        quantisation, mm; short of the tip is above 0.
    places, unseen
        How many positions there are, and how many were left out: unseen in some state.
    refused
        Share of the measurements with all causes that matching would refuse: they count here.
    counts
        How often each stage was worked out now.
    """

    scene: SceneSpec
    seed: int
    causes: list[Cause]
    absent: Mapping[Cause, str]
    shares: Mapping[str, Shares]
    recession_mm: Array
    places: int
    unseen: int
    refused: float
    counts: Counter[str]

    def to_dict(self) -> dict[str, Any]:
        """Give plain values: the keys of ``budget --json``."""
        one = next(iter(self.shares.values()))
        return {
            "scene": self.scene.name,
            "seed": self.seed,
            "detector": self.scene.detect.name,
            "level": self.scene.experiment.level,
            "replicates": one.replicates,
            "positions": self.places,
            "positions_left_out": self.unseen,
            "recession_mm": {
                "mean": float(self.recession_mm.mean()),
                "min": float(self.recession_mm.min()),
                "max": float(self.recession_mm.max()),
            },
            "causes": {str(cause): WITHOUT[cause] for cause in self.causes},
            "absent": {str(cause): why for cause, why in self.absent.items()},
            "refused_by_matching": self.refused,
            **{kind: self._kind(kind) for kind in (POSITION, STEP, FROM_START)},
            "worked_out": {
                name: self.counts.get(name, 0) for name in ("light", "images", "measure")
            },
        }

    def _kind(self, kind: str) -> dict[str, Any] | None:
        shares = self.shares.get(kind)
        if shares is None:
            return None
        total = float(shares.total[0])
        order = rank([float(one[0]) for one in shares.shapley])
        return {
            "rms_mm": float(np.sqrt(max(total, 0))),
            "total_mm2": total,
            "total_ci_mm2": shares.total[1:].tolist(),
            "rest_mm2": float(shares.rest[0]),
            "rest_ci_mm2": shares.rest[1:].tolist(),
            "sum_of_shares_mm2": float(shares.shapley[:, 0].sum()),
            "shares": [
                {
                    "cause": str(self.causes[k]),
                    "percent": None if total == 0 else 100 * float(shares.shapley[k, 0]) / total,
                    "shapley_mm2": float(shares.shapley[k, 0]),
                    "shapley_ci_mm2": shares.shapley[k, 1:].tolist(),
                    "alone_mm2": float(shares.alone[k, 0]),
                    "alone_ci_mm2": shares.alone[k, 1:].tolist(),
                    "removed_mm2": float(shares.removed[k, 0]),
                    "removed_ci_mm2": shares.removed[k, 1:].tolist(),
                    "rms_without_mm": float(np.sqrt(max(total - shares.removed[k, 0], 0))),
                }
                for k in order
            ],
        }


def run_budget(
    scene: SceneSpec,
    out: Path,
    means: Means | None = None,
    *,
    seed: int | None = None,
    replicates: int = REPLICATES,
    allowed: tuple[str, ...] = (),
    retry_failed: bool = False,
    said: Said = lambda _: None,
) -> Budget:
    """Work out a scene's error budget, or go on with it.

    Parameters
    ----------
    scene
        With its `experiment`, of which the first run's positions count.
    out
        Folder of the results.
    means
        What works on it.
    seed
        Root of all random numbers; by default the scene's.
    replicates
        Draws of noise, calibration and interferometer, at least 2.
    allowed
        A detector that is a program or a module, which the caller is willing to run.
    retry_failed
        Whether measurements that failed are tried again.
    said
        Told what is begun.

    Raises
    ------
    InputError
        Something in the scene does not fit, the folder cannot be written, or too few tips were
        found.
    KeyboardInterrupt
        The same call goes on.
    """
    if scene.refine.name != "none":
        raise InputError(
            "has no budget: its causes are those of a detector and of triangulation",
            field="refine.name",
            remedy="write none",
        )
    seed = scene.seed if seed is None else seed
    truth = _truth(scene, series_of(scene, seed), replicates, seed)
    refuse_strangers(out, MADE_BY)
    with alone(out):
        begin(out, scene, seed, MADE_BY)
        starts = _starts(scene, len(truth.tips_mm), replicates, seed)
        order = Order(
            *(scene, seed, truth.tips_mm, truth.true_px, starts, replicates),
            allowed=allowed,
            retry_failed=retry_failed,
        )
        seen = observe(order, out, means or Means(), said)
        causes, absent = present(scene, whole_pixels=seen.whole_pixels)
        errors = Errors(scene, truth, seen, rigs_of(scene, causes, replicates, seed), replicates)
        everything = errors.all(causes)
        places = len(truth.line)
        kept = int(errors.kept[truth.line].sum())
        if kept < LEAST:
            raise InputError(
                f"the tip was seen under all causes at {kept} of {places} positions",
                field="experiment",
                remedy="see its sweeps by `simtip results`, and try another threshold or light",
            )
        level = scene.experiment.level
        shares = {
            kind: split(values, len(causes), level)
            for kind, values in everything.items()
            if values[frozenset()].shape[1] >= LEAST
        }
        made = Budget(
            scene,
            seed,
            causes,
            absent,
            shares,
            errors.recession_mm(frozenset(causes)),
            kept,
            places - kept,
            errors.refused(frozenset(causes)),
            seen.counts,
        )
        text = json.dumps(made.to_dict(), indent=1) + "\n"
        write_atomically(out / RESULT, text.encode())
    return made


def _starts(scene: SceneSpec, places: int, replicates: int, seed: int) -> Array | None:
    """Draw when images begin, (replicates, places), s; None if always at the same moment."""
    if not ripples(scene):
        return None
    jitter = scene.experiment.schedule.start_jitter_s
    drawn = jitter * stream(seed, "budget", "start").random((replicates, places))
    return np.asarray(scene.sensor.start_s + drawn)


def _truth(scene: SceneSpec, planned: list[Series], replicates: int, seed: int) -> Truth:
    """Give what is true of the first run, and of the steps that count for accuracy.

    What the interferometer reads is drawn anew.
    """
    own = planned[0]
    single = next((one for one in planned if one.name == ACCURACY), None)
    numbers: dict[tuple[float, float, float], int] = {}

    def place(tip: Array) -> int:
        return numbers.setdefault(shot_of(tip, 0.0)[0], len(numbers))

    line = np.array([place(tip) for tip in own.tip_mm[0]])
    spec, rng = scene.experiment.interferometer, stream(seed, "budget", "interferometer")
    read = readings(spec, np.tile(own.carriage_mm[0], (replicates, 1)), rng)
    if single is None:
        steps = np.stack([line[:-1], line[1:]], axis=1)
        moved = np.abs(np.diff(read, axis=1))
    else:
        count = scene.experiment.schedule.steps
        steps = np.array([[place(tip) for tip in pair] for pair in single.tip_mm[:count]])
        ends = [readings(spec, single.carriage_mm[:count], rng) for _ in range(replicates)]
        moved = np.abs(np.diff(np.stack(ends), axis=-1))[..., 0]
    tips = np.array(list(numbers))
    return Truth(
        tips_mm=tips,
        true_px=np.stack(scene.rig.rig().project(tips), axis=1),
        axis=unit(np.array(scene.needle.axis)),
        line=line,
        line_laser_mm=read,
        steps=steps,
        steps_laser_mm=moved,
    )
