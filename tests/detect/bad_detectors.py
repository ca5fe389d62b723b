"""Detectors with one fault each. They hold to module level, so that they can be sent elsewhere."""

from __future__ import annotations

import os
import sys
import time
from dataclasses import dataclass

import numpy as np

from simtip.detect import DetectorParameters, FunctionDetector, TipObservation, TipStatus, lin2020

RNG = np.random.default_rng(1)
NO_TIP = TipObservation.failed(TipStatus.NO_EDGE, "there is none")


@dataclass(frozen=True)
class NoParameters(DetectorParameters):
    pass


def moved(seen, du, dv=0.0):
    return seen if seen.tip_px is None else TipObservation.found(seen.tip_px + np.array([du, dv]))


def far_off(image, _p, *, layers=False):
    return moved(lin2020.detect(image, layers=layers), 0, -10)


def half_a_pixel_to_the_right(image, _p, *, layers=False):
    return moved(lin2020.detect(image, layers=layers), 0.5)


def on_a_grid_of_two(image, _p, *, layers=False):
    seen = lin2020.detect(image, layers=layers)
    return seen if seen.tip_px is None else TipObservation.found(seen.tip_px // 2 * 2)


def axis_to_the_tip(image, _p, *, layers=False):
    seen = lin2020.detect(image, layers=layers)
    return seen if not seen.ok else TipObservation.found(seen.tip_px, axis_px=[0.0, 1.0])


def always_at_the_origin(_image, _p, **_layers):
    return TipObservation.found([0, 0])


def lost_in_bright_pictures(image, _p, *, layers=False):
    seen = lin2020.detect(image, layers=layers)
    return moved(seen, 0, -20 * (image.dtype == np.uint8 and np.median(image) > 230))


def wrong_in_16_bits(image, _p, *, layers=False):
    return moved(lin2020.detect(image, layers=layers), int(image.dtype == np.uint16))


def wrong_in_colour(image, _p, *, layers=False):
    return moved(lin2020.detect(image, layers=layers), int(image.ndim == 3))


def between_two(image, _p, **_layers):
    """Middle of all dark columns, lowest dark row."""
    vs, us = np.nonzero(image.reshape(*image.shape[:2], -1)[..., 0] < 105)
    return TipObservation.found([us.mean(), vs.max()]) if len(us) > 4500 else NO_TIP


def random(image, _p, *, layers=False):
    return moved(lin2020.detect(image, layers=layers), RNG.normal(0, 1e-6))


def reads_memory_as_it_lies(image, _p, *, layers=False):
    return moved(lin2020.detect(image, layers=layers), int(not image.flags.c_contiguous))


def takes_anything(_image, _p, **_layers):
    return NO_TIP


def draws_on_its_input(image, _p, *, layers=False):
    seen = lin2020.detect(image, layers=layers)
    if image.flags.writeable:
        image[0, 0] = 77
    return seen


def raises(_image, _p, **_layers):
    raise ZeroDivisionError("division\nby zero")


def gives_a_pair(_image, _p, **_layers):
    return (3.0, 4.0)


def outside(_image, _p, **_layers):
    return TipObservation.found([-33.0, 5.0])


def hangs_on_white(image, _p, *, layers=False):
    while image.min() == 255:
        time.sleep(0.01)
    return lin2020.detect(image, layers=layers)


def dies_on_colour(image, _p, *, layers=False):
    if image.ndim == 3:
        os._exit(3)
    return lin2020.detect(image, layers=layers)


def chats(image, _p, *, layers=False):
    sys.stdout.write("chatter\n")
    return lin2020.detect(image, layers=layers)


def detector(function):
    return FunctionDetector(function.__name__, "is bad", NoParameters, function)
