"""How long a detector takes, in units of a fixed operation that is timed between its calls.

So the speed of the machine cancels, and most of what else it is busy with; where the system tells
(Linux), time in which a thread was ready to run and had no core does not count.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.detect.protocol import for_camera
from simtip.measuring_rig import measuring_rig
from simtip.regress.performed import Observed
from simtip.sweep.pool import Pool, stop
from simtip.sweep.work import Setup, workshop

CONDITIONS = 3
"""That a detector is timed on."""

TURNS, FEWEST_TURNS = 41, 7
TURN_S = 0.02
BUDGET_S = 8.0
"""Of a condition: a slow detector is timed in fewer turns."""

LIMIT_S = 300.0

LEAST_S = 1e-7
MOST_CALLS = 10_000

MAD_TO_SIGMA, MEDIAN_TO_MEAN = 1.4826, 1.2533
"""Of normal values: of their median deviation, and of the standard error of their median."""

SCHEDULER = Path("/proc/thread-self/schedstat")
"""Of this thread on Linux: ns at work, ns waiting for a core, turns (Documentation/scheduler)."""


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


def timed_conditions(observed: Sequence[Sequence[Observed]]) -> list[tuple[int, int]]:
    """Choose conditions to time: with tips, the first three of the quicker half.

    Parameters
    ----------
    observed
        Of every case the conditions.

    Returns
    -------
    places
        Numbers of case and condition.
    """
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
    except Exception:  # noqa: BLE001 (whatever a user's detector does)
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
    spec = plan.scenes.with_values(trial.values)
    detector, rig = trial.measuring.configured(spec), measuring_rig(spec)
    looking = [for_camera(detector, camera) for camera in (rig.left, rig.right)]
    images = stages.shot(trial).images

    def detect() -> None:
        for one, image in zip(looking, images, strict=True):
            one(image)

    with running_time() as clock:
        return measured_ratio(detect, reference_operation(), clock)


def reference_operation() -> Callable[[], None]:
    """Give the operation that is the unit of time: it filters, sorts and transforms a picture.

    Another one would make every baseline's times wrong: with it their format's version changes.
    """
    picture = np.random.default_rng(20).integers(0, 256, (256, 256), dtype=np.uint8)
    wide: NDArray[np.float32] = picture.astype(np.float32)

    def operate() -> None:
        cv2.medianBlur(picture, 5)
        cv2.Canny(picture, 40, 80)
        cv2.GaussianBlur(wide, (15, 15), 3)
        np.sort(wide, axis=None)
        np.fft.rfft2(wide)

    return operate


Clock = Callable[[], float]


@contextmanager
def running_time() -> Iterator[Clock]:
    """Give a clock, s, that stands still while this thread waits for a core, if that is known."""
    try:
        descriptor = os.open(SCHEDULER, os.O_RDONLY)
    except OSError:
        yield time.perf_counter
        return

    def clock() -> float:
        waited_ns = int(os.pread(descriptor, 100, 0).split()[1])
        return time.perf_counter() - 1e-9 * waited_ns

    try:
        yield clock
    finally:
        os.close(descriptor)


def measured_ratio(
    detect: Callable[[], None], reference: Callable[[], None], clock: Clock
) -> Ratio:
    """Time one operation in units of another, in turns of about the same length.

    Parameters
    ----------
    detect, reference
        The operations.
    clock
        In seconds.
    """

    def once(operation: Callable[[], None], count: int = 1) -> float:
        start = clock()
        for _ in range(count):
            operation()
        return max((clock() - start) / count, LEAST_S)

    once(reference)
    once(detect)  # whatever is made at the first call
    # The scheduler's figures may come late, and make a time too short.
    ours_s, unit_s = (float(np.median([once(o) for _ in range(3)])) for o in (detect, reference))
    turn_s = max(TURN_S, ours_s)
    turns = int(min(max(BUDGET_S / (2 * turn_s), FEWEST_TURNS), TURNS))
    ours, units = (int(np.clip(turn_s / one_s, 1, MOST_CALLS)) for one_s in (ours_s, unit_s))
    logs = []
    before = once(reference, units)
    for _ in range(turns):
        spent = once(detect, ours)
        after = once(reference, units)
        logs.append(math.log(spent / (0.5 * (before + after))))
        before = after
    centre = float(np.median(logs))
    deviation = MAD_TO_SIGMA * float(np.median(np.abs(np.array(logs) - centre)))
    return Ratio(math.exp(centre), MEDIAN_TO_MEAN * deviation / math.sqrt(turns))
