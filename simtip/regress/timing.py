"""How long a detector takes, in units of a fixed operation that is timed between its calls.

So the speed of the machine, and most of what else it is busy with, cancels.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.measuring_rig import measuring_rig
from simtip.regress.performed import Observed, Planned
from simtip.sweep.pool import Pool, stop
from simtip.sweep.work import Setup, workshop
from simtip.trial import measured

CONDITIONS = 3
BLOCKS = 15
FEWEST_BLOCKS = 5
BLOCK_S = 0.04
BUDGET_S = 8.0
"""Of a condition: a slow detector is timed in fewer blocks."""

LIMIT_S = 300.0


@dataclass(frozen=True)
class Asked:
    """A pair of images to time a detector on: a trial of a sweep."""

    setup: Setup
    trial: int


@dataclass(frozen=True)
class Ratio:
    """Time of a detector for a pair of images over that of the reference operation.

    Attributes
    ----------
    ratio
        Median over blocks.
    scatter
        Standard error of its logarithm.
    """

    ratio: float
    scatter: float


def timed_conditions(cases: Sequence[Planned], observed: Sequence[Sequence[Observed]]) -> list[tuple[int, int]]:
    """Choose conditions to time: with tips, the first three of the quicker half."""
    known = [
        (one.detect_s, place, k)
        for place, conditions in enumerate(observed)
        for k, one in enumerate(conditions)
        if one.detect_s is not None and one.sample.found.any()
    ]
    quick = sorted(known)[: max(CONDITIONS, (len(known) + 1) // 2)]
    places = sorted((place, k) for _, place, k in quick)
    return places[:CONDITIONS]


def time_in_worker(pool: Pool, asked: Asked) -> Ratio | None:
    """Time a detector in a process of its own, all others idle.

    Returns
    -------
    ratio
        None if it did not come to an end.
    """
    executor = pool.executor()
    future: Future[Ratio] = executor.submit(ratio_of, asked)
    try:
        found = future.result(timeout=LIMIT_S)
    except (BrokenExecutor, FutureTimeoutError, InputError):
        stop(executor)
        return None
    except BaseException:
        stop(executor)
        raise
    pool.give_back(executor)
    return found


def ratio_of(asked: Asked) -> Ratio:
    """Time a detector on a pair of images, in this process."""
    plan, stages = workshop(asked.setup)
    trial = plan.trial(asked.trial)
    shot, truth = stages.shot(trial), stages.truth(trial)
    spec = plan.scenes.with_values(trial.values).model_copy(
        update={"detect": trial.measuring.spec}
    )
    detector, rig = trial.measuring.configured(spec), measuring_rig(spec)

    def detect() -> float:
        found, _ = measured(shot.images, truth, spec, detector, rig=rig, refiner=None)
        return found.timings_s["detect"]

    return measured_ratio(detect, reference_operation())


def reference_operation() -> Callable[[], float]:
    """Give the operation that is the unit of time: it filters, sorts and transforms a picture."""
    picture = np.random.default_rng(20).integers(0, 256, (384, 384), dtype=np.uint8)
    wide: NDArray[np.float32] = picture.astype(np.float32)

    def operate() -> float:
        start = time.perf_counter()
        cv2.medianBlur(picture, 5)
        cv2.Canny(picture, 40, 80)
        cv2.GaussianBlur(wide, (15, 15), 3)
        np.sort(wide, axis=None)
        np.fft.rfft2(wide)
        return time.perf_counter() - start

    return operate


def measured_ratio(detect: Callable[[], float], reference: Callable[[], float]) -> Ratio:
    """Time one operation in units of another, in turns of about the same length.

    Parameters
    ----------
    detect, reference
        Each works once and gives its time, s.
    """
    reference()
    once = max(detect(), 1e-7)
    once = max(min(once, detect()), 1e-7)
    unit = max(min(reference(), reference()), 1e-7)
    block_s = max(BLOCK_S, once)
    blocks = int(min(max(BUDGET_S / (2 * block_s), FEWEST_BLOCKS), BLOCKS))
    ours, units = max(1, round(block_s / once)), max(1, round(block_s / unit))
    logs = []
    before = _mean(reference, units)
    for _ in range(blocks):
        spent = _mean(detect, ours)
        after = _mean(reference, units)
        logs.append(math.log(max(spent, 1e-9) / (0.5 * (before + after))))
        before = after
    centre = float(np.median(logs))
    deviation = 1.4826 * float(np.median(np.abs(np.array(logs) - centre)))
    return Ratio(math.exp(centre), 1.25 * deviation / math.sqrt(blocks))


def _mean(operation: Callable[[], float], count: int) -> float:
    return sum(operation() for _ in range(count)) / count
