"""Work in pieces: small enough for a live progress bar, large enough to amortise a launch."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from simtip.render.engine import dr

LAUNCH_SAMPLES = 1 << 21
ALIGNMENT = 64  # bytes
Report = Callable[[int], None]
"""Told the number of samples just done."""

Item = TypeVar("Item", bound=np.generic)


def batches(items: NDArray[Item], samples: int) -> Iterator[NDArray[Item]]:
    """Split along the first axis so that a launch takes about LAUNCH_SAMPLES samples."""
    step = max(1, LAUNCH_SAMPLES // samples)
    for start in range(0, len(items), step):
        yield items[start : start + step]


def aligned(values: NDArray[Item]) -> NDArray[Item]:
    """Copy to memory as Dr.Jit would have it.

    It reads NumPy's memory in place, and compiles a kernel for every alignment that it meets.
    """
    room = np.empty(values.nbytes + ALIGNMENT, np.uint8)
    start = -room.ctypes.data % ALIGNMENT
    copy: NDArray[Item] = room[start : start + values.nbytes].view(values.dtype)
    copy = copy.reshape(values.shape)
    copy[...] = values
    return copy


def means(values: list[Any], samples: int) -> NDArray[np.float32]:
    """Average each value over every item's samples: (items, values).

    One evaluation for all: a reduction evaluates what it is given, so that values reduced one by
    one would each trace all rays again.
    """
    dr.eval(values)
    sums = [dr.block_sum(value, samples).numpy() for value in values]
    averages: NDArray[np.float32] = np.stack(sums, axis=-1, dtype=np.float32)
    averages /= np.float32(samples)
    return averages
