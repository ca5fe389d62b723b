"""Threads of the libraries in a worker process, so that several share a machine."""

from __future__ import annotations

import os

import cv2
from threadpoolctl import threadpool_limits

VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""What a user's detector in a process of its own may look at."""


def use_threads(count: int) -> None:
    """Let OpenCV and BLAS of this process, and programs it starts, use so many threads."""
    cv2.setNumThreads(count)
    threadpool_limits(limits=count)
    for name in VARIABLES:
        os.environ[name] = str(count)
