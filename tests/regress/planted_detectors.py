"""The paper's detector with a fault planted in it, each a function that a command line can name."""

from __future__ import annotations

import time
import zlib
from functools import cache

import numpy as np

from simtip.detect import configure

PARAMETERS = {"min_area_px": 300}


@cache
def _lin2020():
    return configure("lin2020", PARAMETERS)


def _chance(image) -> float:
    """Give what looks like chance, from 0 to 1, and is the same for the same image."""
    return zlib.crc32(np.ascontiguousarray(image).tobytes()) / 2**32


def unchanged(image):
    return _lin2020()(image).tip_px


def moved(image):
    tip = unchanged(image)
    return None if tip is None else tip + np.array([0.5, 0.0])


def forgetful(image):
    return None if _chance(image) < 0.05 else unchanged(image)


def hardly_forgetful(image):
    return None if _chance(image) < 0.03 else unchanged(image)


def very_forgetful(image):
    return None if _chance(image) < 0.25 else unchanged(image)


def shaky(image):
    tip = unchanged(image)
    noise = np.random.default_rng(int(_chance(image) * 2**32)).normal(0, 0.5, 2)
    return None if tip is None else tip + noise


def straying(image):
    tip = unchanged(image)
    return tip if tip is None or _chance(image) > 0.2 else tip + np.array([0.0, -40.0])


def twice(image):
    _lin2020()(image)
    return unchanged(image)


def sleepy(image):
    start = time.perf_counter()
    tip = unchanged(image)
    time.sleep(1.2 * (time.perf_counter() - start) + 1e-3)
    return tip


def true_to_the_pixel(image):
    """Nearer the truth: the paper's detector stops some 8 px short."""
    tip = unchanged(image)
    return None if tip is None else tip + np.array([0.0, 8.0])


def broken(image):
    raise RuntimeError(f"out of order at {image.shape}")
