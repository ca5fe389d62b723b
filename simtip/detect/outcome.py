"""What a user's detector gives, checked and made a `TipObservation`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from simtip.detect.excerpt import excerpt
from simtip.detect.observation import Layers, TipObservation, TipStatus
from simtip.geometry import Array

MAX_VARIANCE_PX2 = 1e12
"""A covariance beyond this is a fault: no image is a million pixels wide."""


class InvalidOutputError(Exception):
    """What was given is no observation; the text says why."""


def observed(result: object, shape: tuple[int, ...]) -> TipObservation:
    """Make an observation of what a user's detector gave.

    Parameters
    ----------
    result
        A `TipObservation`; (u, v) in px; None: there is no tip; or a mapping with ``tip_px`` (u, v)
        and, if known, ``axis_px`` (or ``axis``), ``covariance_px``, ``confidence`` and ``layers``;
        or one with ``reason`` and maybe ``status``, where there is no tip. Other keys are ignored.
    shape
        Of the image, (H, W, ...): a tip more than an image's size off the image is a fault.

    Returns
    -------
    TipObservation
        With the status ``invalid_output`` if the result is none of these.
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            seen = _observation(result)
        _check_place(seen, shape)
    except (InvalidOutputError, ValueError, OverflowError) as error:
        return TipObservation.failed(TipStatus.INVALID_OUTPUT, excerpt(str(error)))
    return seen


def _observation(result: object) -> TipObservation:
    if isinstance(result, TipObservation):
        return result
    if result is None:
        return TipObservation.failed(TipStatus.NOT_FOUND, "the detector found no tip")
    if isinstance(result, Mapping):
        return _of_mapping(result)
    if isinstance(result, (tuple, list, np.ndarray)):
        return TipObservation.found(_numbers(result, (2,), "the tip"))
    raise InvalidOutputError(
        f"it gave {_kind(result)}, neither a tip (u, v) nor an observation nor None"
    )


def _of_mapping(said: Mapping[object, object]) -> TipObservation:
    status, reason = said.get("status"), said.get("reason")
    layers = _layers(said.get("layers"))
    found = status is None or str(status).lower() in ("", "ok")
    if not found:
        return _failure(str(status), reason, layers)
    tip = said.get("tip_px")
    if tip is None and reason:
        return _failure("", reason, layers)
    if "tip_px" not in said or (tip is None and status):
        raise InvalidOutputError("it says neither tip_px nor why there is none (status, reason)")
    if tip is None:
        return TipObservation.failed(TipStatus.NOT_FOUND, "the detector found no tip")
    axis = said.get("axis_px", said.get("axis"))
    covariance = said.get("covariance_px")
    return TipObservation.found(
        _numbers(tip, (2,), "tip_px"),
        axis_px=None if axis is None else _numbers(axis, (2,), "axis_px"),
        covariance_px=None if covariance is None else _covariance(covariance),
        confidence=_confidence(said.get("confidence")),
        layers=layers,
    )


def _failure(status: str, reason: object, layers: Layers) -> TipObservation:
    """Keep a status that is one of simtip's; any other is part of the reason."""
    text = excerpt(str(reason)) if reason else ""
    if status in {known.value for known in TipStatus}:
        return TipObservation.failed(TipStatus(status), text or f"it says {status}", layers=layers)
    words = [part for part in (excerpt(status, 60), text) if part]
    return TipObservation.failed(TipStatus.NOT_FOUND, ": ".join(words), layers=layers)


def _covariance(value: object) -> Array:
    covariance = _numbers(value, (2, 2), "covariance_px")
    if np.abs(covariance).max() > MAX_VARIANCE_PX2:
        raise InvalidOutputError(f"covariance_px is beyond {MAX_VARIANCE_PX2:g} px^2")
    return covariance


def _confidence(value: object) -> float | None:
    return None if value is None else float(_numbers(value, (), "confidence"))


def _layers(value: object) -> dict[str, NDArray[np.generic]]:
    """Keep what is an array; a picture for an overlay is no reason to lose a tip."""
    given = value if isinstance(value, Mapping) else {}
    return {str(name): layer for name, layer in given.items() if isinstance(layer, np.ndarray)}


def _numbers(value: object, shape: tuple[int, ...], what: str) -> Array:
    """Convert numbers; unlike NumPy take no text and no truth value for one."""
    wanted = " x ".join(map(str, shape)) + " numbers" if shape else "a number"
    if any(isinstance(one, bool) for one in _scalars(value)):  # NumPy takes them for 0 and 1
        raise InvalidOutputError(f"{what} is {_kind(value)}, not {wanted}")
    try:
        array = np.asarray(value)
    except ValueError:  # ragged lists
        raise InvalidOutputError(f"{what} is {_kind(value)}, not {wanted}") from None
    if array.dtype.kind not in "iuf" or array.shape != shape:
        raise InvalidOutputError(f"{what} is {_kind(value)}, not {wanted}")
    if not np.isfinite(array).all():
        raise InvalidOutputError(f"{what} is not finite")
    return array.astype(np.float64)


def _scalars(value: object) -> Iterator[object]:
    """Give what is in lists of a few levels."""
    if isinstance(value, list | tuple):
        for one in value:
            yield from (one if isinstance(one, list | tuple) else (one,))
    else:
        yield value


def _kind(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} of shape {value.shape}"
    return f"{type(value).__name__} {excerpt(repr(value), 60)}"


def _check_place(seen: TipObservation, shape: tuple[int, ...]) -> None:
    if seen.tip_px is None:
        return
    height, width = shape[:2]
    size = np.array([width, height])
    if (seen.tip_px < -size).any() or (seen.tip_px > 2 * size).any():
        u, v = seen.tip_px
        raise InvalidOutputError(
            f"the tip ({u:g}, {v:g}) is nowhere near the image of {width} x {height} px"
        )
