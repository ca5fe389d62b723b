"""The exposure time that brings the background to a wanted gray level.

The level asked for is the mean over both cameras of the gray level that each one's background is
expected to have, saturation included. Each camera counts by its own light: lenses may differ.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.sensor import UNIFORM, dark_electrons, expected_dn, gains, responsivity
from simtip.spec import SensorSpec

GRAY = np.array([0.299, 0.587, 0.114])
"""Weights of the gray level, ITU-R BT.601, as detectors commonly use them."""

MOST_GAIN = 20.0

SHORTEST_S, LONGEST_S = 1e-6, 100.0

CLOSE_DN = 0.2
"""How near to the wanted level the light of the exposure found has to bring the background."""

LOST, UNLIKE = 0.02, 1.05
"""A background that would exceed its range by this share is refused if the other camera's is darker
by more than this factor."""

_ROUNDS = 40

Backgrounds = Callable[[SensorSpec], NDArray[np.float64]]
"""From a sensor, its exposure time set, to the irradiance (cameras, 3) of the backgrounds then."""


def background_irradiance(
    irradiance: NDArray[np.float32], coverage: NDArray[np.float32]
) -> NDArray[np.float64]:
    """Give the median irradiance (3,), W m^-2, of pixels (H, W, 3) that nothing covers.

    All pixels count if everything is covered.
    """
    free = coverage == 0
    pixels = irradiance[free] if free.any() else irradiance.reshape(-1, 3)
    return np.median(pixels, axis=0).astype(np.float64)


def settle_white_balance(backgrounds: Backgrounds, sensor: SensorSpec) -> SensorSpec:
    """Set the channels' gains so that the backgrounds come out gray, if the sensor asks for it.

    Parameters
    ----------
    backgrounds
        Gives the irradiance of the backgrounds; their mean counts.
    sensor
        With `auto_white_balance` or without; then it is returned as it is.

    Raises
    ------
    InputError
        A channel sees no light of the background, or too little.
    """
    if not sensor.auto_white_balance:
        return sensor
    # An exposure so long sees no ripple, and is the same whatever the scene says.
    timed = _timed(sensor, LONGEST_S)
    electrons = backgrounds(timed).mean(axis=0) * responsivity(timed)
    with np.errstate(divide="ignore", invalid="ignore"):
        factors = electrons.max() / electrons
    if not (np.isfinite(factors).all() and factors.max() <= MOST_GAIN):
        raise InputError(
            f"the background's channels collect {', '.join(f'{e:.3g}' for e in electrons)} e-: no "
            f"gain up to {MOST_GAIN:g} balances them",
            field="sensor.auto_white_balance",
            remedy="give light of another colour, or white_balance instead",
        )
    return sensor.model_copy(update={"white_balance": tuple(factors.tolist())})


def gray_level(irradiance: NDArray[np.float64], sensor: SensorSpec) -> float:
    """Give the expected gray level, DN, of an even irradiance, W m^-2.

    Parameters
    ----------
    irradiance
        (3,), or (cameras, 3): then the mean of the cameras' levels.
    sensor
        With its exposure time.
    """
    return float(_gray_levels(irradiance, sensor).mean())


def _gray_levels(irradiance: NDArray[np.float64], sensor: SensorSpec) -> NDArray[np.float64]:
    levels: NDArray[np.float64] = (
        expected_dn(irradiance.reshape(1, -1, 3), sensor, camera=UNIFORM)[0] @ GRAY
    )
    return levels


def auto_expose(irradiance: NDArray[np.float64], sensor: SensorSpec) -> SensorSpec:
    """Set the exposure time so that backgrounds have the gray level `sensor.background_dn`.

    Parameters
    ----------
    irradiance
        (3,) of one background, or (cameras, 3): then the mean of their gray levels counts. W m^-2,
        whatever the exposure.
    sensor
        What `background_dn` it asks for; without one it is returned as it is.

    Raises
    ------
    InputError
        No exposure from 1 us to 100 s gives that level.
    """
    wanted = sensor.background_dn
    if wanted is None:
        return sensor

    target = float(wanted)

    def excess(log_s: float) -> float:
        return gray_level(irradiance, _timed(sensor, float(np.exp(log_s)))) - target

    ends = float(np.log(SHORTEST_S)), float(np.log(LONGEST_S))
    lowest, highest = excess(ends[0]), excess(ends[1])
    if not (lowest < 0 < highest):
        raise _out_of_reach(target, lowest + target, highest + target)
    return _timed(sensor, float(np.exp(scipy.optimize.brentq(excess, *ends, xtol=1e-10))))


def settle_exposure(backgrounds: Backgrounds, sensor: SensorSpec) -> SensorSpec:
    """Set the exposure time where the light itself depends on it, as rippling lamps' does.

    What an exposure collects rises with its length whatever the ripple, so the answer stays between
    the longest one found too dark and the shortest found too bright.

    Parameters
    ----------
    backgrounds
        Gives the irradiance of the backgrounds for an exposure.
    sensor
        What `background_dn` it asks for; without one it is returned as it is.

    Raises
    ------
    InputError
        No exposure from 1 us to 100 s gives that level, or the cameras' backgrounds differ so much
        that one saturates (`LOST`, `UNLIKE`).
    """
    if sensor.background_dn is None:
        return sensor
    target = float(sensor.background_dn)
    short, long = SHORTEST_S, LONGEST_S
    # An exposure so long sees no ripple: the right start, and proof that the level can be reached.
    guess = auto_expose(backgrounds(_timed(sensor, LONGEST_S)), sensor).exposure_s
    tried: list[tuple[float, float]] = []
    for _ in range(_ROUNDS):
        timed = _timed(sensor, guess)
        light = backgrounds(timed)
        excess = gray_level(light, timed) - target
        if abs(excess) <= CLOSE_DN:
            _require_alike(light, timed)
            return timed
        short, long = (guess, long) if excess < 0 else (short, guess)
        tried.append((guess, excess))
        guesses = [_by_secant(tried), _by_light(light, sensor), float(np.sqrt(short * long))]
        if len(tried) % 4 == 0:  # whatever the ripple, the ends come together
            guesses = guesses[-1:]
        guess = next(t for t in guesses if short < t < long)
    ends = (gray_level(light, _timed(sensor, end)) for end in (SHORTEST_S, LONGEST_S))
    raise _out_of_reach(target, *ends)


def _by_secant(tried: list[tuple[float, float]]) -> float:
    """Follow the line through the last two levels to 0; 0 if there is none."""
    if len(tried) < 2:
        return 0.0
    (t0, excess0), (t1, excess1) = tried[-2:]
    if t0 == t1 or excess0 == excess1:
        return 0.0
    return t1 - excess1 * (t1 - t0) / (excess1 - excess0)


def _by_light(irradiance: NDArray[np.float64], sensor: SensorSpec) -> float:
    """Give the right exposure if the light stays as it is; 0 if there is hardly any."""
    try:
        return auto_expose(irradiance, sensor).exposure_s
    except InputError:
        return 0.0


def _require_alike(irradiance: NDArray[np.float64], sensor: SensorSpec) -> None:
    """Refuse backgrounds of which one saturates and another is darker."""
    collected = irradiance * responsivity(sensor) + dark_electrons(sensor)
    limit = (2**sensor.bit_depth - 1 - sensor.black_level_dn) / gains(sensor)
    if sensor.effects.full_well:
        limit = np.minimum(limit, sensor.full_well_e)
    lost = np.maximum(collected / limit - 1, 0) @ GRAY
    gray = collected @ GRAY
    if lost.max() <= LOST or gray.max() <= UNLIKE * gray.min():
        return
    unsaturated = _timed(sensor, sensor.exposure_s / float((collected / limit).max()))
    levels = _gray_levels(irradiance, sensor)
    raise InputError(
        f"a mean of {sensor.background_dn:g} DN means {levels[0]:.0f} DN left and {levels[1]:.0f} "
        f"DN right, where the {('left', 'right')[int(lost.argmax())]} background is saturated",
        field="sensor.background_dn",
        remedy="give f-numbers that make both backgrounds as bright, or ask for at most "
        f"{np.floor(gray_level(irradiance, unsaturated)):g} DN",
    )


def _out_of_reach(wanted: float, lowest: float, highest: float) -> InputError:
    return InputError(
        f"{wanted:g} DN cannot be reached: exposures from 1 us to 100 s give "
        f"{lowest:.1f} to {highest:.1f} DN",
        field="sensor.background_dn",
        remedy="ask for another level, or change the light or the gain",
    )


def _timed(sensor: SensorSpec, exposure_s: float) -> SensorSpec:
    return sensor.model_copy(update={"exposure_s": exposure_s})
