"""Where a stage takes the needle, run after run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.geometry import Array
from simtip.spec.experiment import ScheduleSpec, StageSpec


@dataclass(frozen=True, eq=False)
class Motion:
    """Where the first axis was, in runs of positions.

    Attributes
    ----------
    commanded_mm, carriage_mm, needle_mm
        (runs, positions): what was asked for, where the carriage with its reflector stopped, and
        where the needle came to be.
    """

    commanded_mm: Array
    carriage_mm: Array
    needle_mm: Array


def positions_of(schedule: ScheduleSpec) -> Array:
    """Give the positions (steps + 1,) of a run on the first axis, mm."""
    return schedule.start_mm + schedule.step_mm * np.arange(schedule.steps + 1, dtype=np.float64)


def drive(stage: StageSpec, positions_mm: Array, rng: np.random.Generator) -> Motion:
    """Drive the first axis, run after run.

    Before each run, the first too, the stage comes back from the run's last position.

    Parameters
    ----------
    stage
        Its errors.
    positions_mm
        (runs, positions), rising in every run.
    rng
        Of where it stops.
    """
    commanded = positions_mm
    stops = stage.positioning_mm * rng.standard_normal(commanded.shape)
    motor = _whole(commanded, stage.resolution_mm) + stops
    carriage, needle = np.empty_like(motor), np.empty_like(motor)
    lead = _Play(stage.backlash_mm, commanded[0, -1])
    mount = _Play(abs(stage.needle_play_mm), commanded[0, -1])
    for run, places in enumerate(motor):
        mount.follow(lead.follow(commanded[run, -1]))
        # With no overrun the start itself is come to backward.
        mount.follow(lead.follow(places[0] - stage.overrun_mm))
        for k, place in enumerate(places):
            carriage[run, k] = lead.follow(place)
            lag = mount.follow(carriage[run, k]) - carriage[run, k]
            needle[run, k] = carriage[run, k] + np.copysign(lag, lag * stage.needle_play_mm)
    return Motion(commanded, carriage, needle)


def coordinates(stage: StageSpec, first_mm: Array, others_mm: Array | None = None) -> Array:
    """Give the needle's place in the stage's coordinates.

    Parameters
    ----------
    stage
        Its straightness and resolution.
    first_mm
        (...) of the needle on the first axis.
    others_mm
        (..., 2) asked of the other two; None is where the scene's needle is.

    Returns
    -------
    places
        (..., 3) mm.
    """
    places = np.empty((*first_mm.shape, 3))
    places[..., 0] = first_mm
    places[..., 1:] = stage.origin_mm[1:]
    if others_mm is not None:
        places[..., 1:] = _whole(others_mm, stage.resolution_mm)
    places[..., 1] += _bow(stage, first_mm) - _bow(stage, np.array(stage.origin_mm[0]))
    return places


def _bow(stage: StageSpec, first_mm: Array) -> Array:
    """Give how far the first axis is off the line through its ends, mm."""
    share = first_mm / stage.stroke_mm[0]
    bow: Array = 4 * stage.straightness_mm * share * (1 - share)
    return bow


def grid(stage: StageSpec, counts: tuple[int, int, int]) -> tuple[Array, Array]:
    """Give evenly spaced positions over the strokes: (n,) of the first axis, (m, 2) of the others.

    An axis with one position stays where the scene's needle is.
    """
    along, *rest = (
        np.linspace(0, stroke, count) if count > 1 else np.array([origin])
        for count, stroke, origin in zip(counts, stage.stroke_mm, stage.origin_mm, strict=True)
    )
    others = np.stack(np.meshgrid(*rest, indexing="ij"), axis=-1).reshape(-1, 2)
    return along, others


class _Play:
    """Lost motion: a follower that is pushed only when the gap is used up."""

    def __init__(self, width_mm: float, place_mm: float) -> None:
        self._half, self._place = width_mm / 2, place_mm - width_mm / 2

    def follow(self, driver_mm: float) -> float:
        """Give where the follower is, mm, once the driver has come to a place."""
        self._place = min(max(self._place, driver_mm - self._half), driver_mm + self._half)
        return self._place


def _whole(values_mm: Array, resolution_mm: float) -> Array:
    """Round to whole multiples of a resolution; 0 leaves all as it is."""
    if resolution_mm == 0:
        return values_mm
    rounded: Array = np.round(values_mm / resolution_mm) * resolution_mm
    return rounded
