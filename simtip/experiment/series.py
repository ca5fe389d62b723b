"""The trials of an experiment: one sweep a set-up, in which every distinct place is one render."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.experiment.interferometer import readings
from simtip.experiment.stage import Motion, coordinates, drive, grid, positions_of
from simtip.geometry import Array
from simtip.seeding import seed32, stream
from simtip.spec import SceneSpec
from simtip.spec.experiment import OWN_SETUP, ExperimentSpec
from simtip.spec.recalibration import RecalibrationSpec
from simtip.sweep.assignment import Scenes
from simtip.sweep.campaign import cores
from simtip.sweep.plan import Plan
from simtip.sweep.spec import MEASURED, SweepSpec
from simtip.truth import scene_truth

TIP, START = "needle.tip_mm", "sensor.start_s"
REGISTRATION, ACCURACY = "registration", "accuracy"
"""Series that are no set-up."""

Numbers = NDArray[np.intp]
Shot = tuple[tuple[float, float, float], float]
"""A tip, world, mm, and the moment at which a pair of images of it begins, s."""


@dataclass(frozen=True, eq=False)
class Series:
    """What is driven and measured in one set-up.

    Attributes
    ----------
    name
        Of the set-up, or "accuracy" or "registration".
    changes
        Fields of the scene that are other.
    calibration
        How the rig that measures was calibrated for this series; None: it is the first set-up's.
    stage_mm
        (runs, positions, 3) where the needle is in the stage's coordinates, mm.
    commanded_mm
        (runs, positions, 3) where it was asked to be.
    carriage_mm, laser_mm
        (runs, positions) where the carriage is on the first axis, and what the interferometer
        reads, mm.
    tip_mm
        (runs, positions, 3) the needle's tip, world, mm.
    start_s
        (runs, positions) when the pair of images begins, s.
    """

    name: str
    changes: Mapping[str, Any]
    calibration: RecalibrationSpec | None
    commanded_mm: Array
    stage_mm: Array
    carriage_mm: Array
    laser_mm: Array
    tip_mm: Array
    start_s: Array

    @property
    def is_setup(self) -> bool:
        """Whether it is the scene's own or another set-up, driven along the first axis."""
        return self.name not in {ACCURACY, REGISTRATION}

    def shots(self) -> tuple[list[Shot], Numbers, Numbers]:
        """Tell distinct pairs of images, but for their noise.

        Returns
        -------
        shots
            Where the tip is, world, mm, and when they begin, s.
        shot, turn
            (runs, positions) each: which of them, and for the how manieth time, from 0.
        """
        found: dict[Shot, int] = {}
        seen: Counter[int] = Counter()
        shape = self.tip_mm.shape[:2]
        shot, turn = np.empty(shape, np.intp), np.empty(shape, np.intp)
        for index in np.ndindex(shape):
            one = shot_of(self.tip_mm[index], float(self.start_s[index]))
            number = found.setdefault(one, len(found))
            shot[index], turn[index] = number, seen[number]
            seen[number] += 1
        return list(found), shot, turn

    def sweep(
        self,
        scene: SceneSpec,
        seed: int,
        *,
        rig: str | None = None,
        render_for: Mapping[str, Any] | None = None,
        allowed: tuple[str, ...] = (),
    ) -> Plan:
        """Give its trials.

        Parameters
        ----------
        scene
            The scene.
        seed
            Root of all random numbers.
        rig
            File of the rig that measures, if it is not the scene's.
        render_for
            Fields that the light is rendered for, so that set-ups share it.
        allowed
            A detector that is a program or a module, which the caller is willing to run.

        Raises
        ------
        InputError
            A changed field does not exist, or a value does not fit.
        """
        shots, _, turn = self.shots()
        base = dict(self.changes) if rig is None else {**self.changes, MEASURED: rig}
        spec = SweepSpec(
            scene="",
            base=base,
            render_for=dict(render_for or {}),
            zipped=[zipped_shots(shots)],
            repeats=int(turn.max()) + 1,
            seed=seed32(seed, "experiment", self.name, "noise"),
        )
        return Plan(spec, scene.model_copy(update={"experiment": ExperimentSpec()}), allowed)


def series_of(scene: SceneSpec, seed: int) -> list[Series]:
    """Plan an experiment: the scene's own set-up, the others, and the registration.

    Parameters
    ----------
    scene
        With its experiment.
    seed
        Root of all random numbers.

    Raises
    ------
    InputError
        The needle's tip would leave an image.
    """
    spec = scene.experiment
    runs = spec.schedule.runs
    made = [_line(scene, seed, OWN_SETUP, {}, None, runs)]
    for number, one in enumerate(spec.setups):
        runs = spec.schedule.setup_runs
        try:
            made.append(_line(scene, seed, one.name, one.set, one.recalibrate, runs))
            made[-1].sweep(scene, seed)
        except InputError as error:
            said = f"{error.field} {error.problem}" if error.field else error.problem
            field = f"experiment.setups[{number}].set"
            raise InputError(said, field=field, remedy=error.remedy) from error
    if spec.schedule.accuracy_turns:
        made.append(_single_steps(scene, seed))
    if spec.schedule.registration is not None:
        made.append(_registration(scene, seed, spec.schedule.registration))
    return made


def _line(
    scene: SceneSpec,
    seed: int,
    name: str,
    changes: Mapping[str, Any],
    calibration: RecalibrationSpec | None,
    runs: int,
) -> Series:
    """Plan runs along the first axis."""
    positions = np.tile(positions_of(scene.experiment.schedule), (runs, 1))
    return _driven(scene, seed, name, changes, calibration, positions)


def _single_steps(scene: SceneSpec, seed: int) -> Series:
    """Plan every step as a run of its own."""
    plan = scene.experiment.schedule
    ends = positions_of(plan)
    steps = np.tile(np.stack([ends[:-1], ends[1:]], axis=1), (plan.accuracy_runs, 1))
    return _driven(scene, seed, ACCURACY, {}, None, steps)


def _driven(
    scene: SceneSpec,
    seed: int,
    name: str,
    changes: Mapping[str, Any],
    calibration: RecalibrationSpec | None,
    positions_mm: Array,
) -> Series:
    stage = scene.experiment.stage
    motion = drive(stage, positions_mm, stream(seed, "experiment", name, "stage"))
    asked = np.empty((*motion.commanded_mm.shape, 3))
    asked[..., 0], asked[..., 1:] = motion.commanded_mm, stage.origin_mm[1:]
    places = coordinates(stage, motion.needle_mm)
    return _series(scene, seed, name, changes, calibration, motion, asked, places)


def _registration(scene: SceneSpec, seed: int, counts: tuple[int, int, int]) -> Series:
    """Plan a grid over all three axes, a run for every place of the second and third."""
    spec = scene.experiment
    along, others = grid(spec.stage, counts)
    rng = stream(seed, "experiment", REGISTRATION, "stage")
    motion = drive(spec.stage, np.tile(along, (len(others), 1)), rng)
    across = np.broadcast_to(others[:, None], (len(others), len(along), 2))
    asked = np.concatenate([motion.commanded_mm[..., None], across], axis=-1)
    places = coordinates(spec.stage, motion.needle_mm, across)
    return _series(scene, seed, REGISTRATION, {}, None, motion, asked, places)


def _series(
    scene: SceneSpec,
    seed: int,
    name: str,
    changes: Mapping[str, Any],
    calibration: RecalibrationSpec | None,
    motion: Motion,
    asked: Array,
    places: Array,
) -> Series:
    spec = scene.experiment
    rng = stream(seed, "experiment", name, "interferometer")
    laser = readings(spec.interferometer, motion.carriage_mm, rng)
    axes = spec.stage.axes(scene.needle.axis)
    tips = np.array(scene.needle.tip_mm) + (places - np.array(spec.stage.origin_mm)) @ axes
    seen_by = Scenes(scene).with_values(changes) if changes else scene
    _require_in_view(seen_by, tips.reshape(-1, 3), places.reshape(-1, 3), name)
    starts = _starts(scene, seed, name, places.shape[:2])
    return Series(
        name, changes, calibration, asked, places, motion.carriage_mm, laser, tips, starts
    )


def shot_of(tip_mm: Array, start_s: float) -> Shot:
    """Give a pair of images as it is told from others."""
    x, y, z = (round(float(value), 9) for value in tip_mm)
    return (x, y, z), round(float(start_s), 9)


def zipped_shots(shots: Sequence[Shot]) -> dict[str, list[Any]]:
    """Give what varies from one pair of images to the next, for a sweep.

    So many places as there are cores come in turn, until all their images are taken: then each core
    has a place's light at hand, and none waits for another to render it.
    """
    shots = _in_turn(shots, cores())
    said: dict[str, list[Any]] = {TIP: [list(tip) for tip, _ in shots]}
    starts = [start for _, start in shots]
    if len(set(starts)) > 1:
        said[START] = starts
    return said


def _in_turn(shots: Sequence[Shot], width: int) -> list[Shot]:
    by_place: dict[tuple[float, ...], list[Shot]] = {}
    for shot in shots:
        by_place.setdefault(shot[0], []).append(shot)
    places = list(by_place.values())
    ordered = []
    for first in range(0, len(places), width):
        turns = itertools.zip_longest(*places[first : first + width])
        ordered += [shot for turn in turns for shot in turn if shot is not None]
    return ordered


def _starts(scene: SceneSpec, seed: int, name: str, shape: tuple[int, ...]) -> Array:
    """Draw when every pair of images begins."""
    jitter = scene.experiment.schedule.start_jitter_s
    rng = stream(seed, "experiment", name, "start")
    drawn: Array = scene.sensor.start_s + jitter * rng.random(shape)
    return drawn


def _require_in_view(
    scene: SceneSpec, tips: Iterable[Array], places: Iterable[Array], name: str
) -> None:
    """Refuse places at which a camera does not see the tip."""
    rig = scene.rig.rig()
    distinct = {tuple(tip.tolist()): place for tip, place in zip(tips, places, strict=True)}
    for tip, place in distinct.items():
        needle = scene.needle.model_copy(update={"tip_mm": tip})
        truth = scene_truth(scene.model_copy(update={"needle": needle}))
        for side, view, camera in (
            ("left", truth.left, rig.left),
            ("right", truth.right, rig.right),
        ):
            if not camera.contains(view.tip_px):
                field = "schedule.registration" if name == REGISTRATION else "stage.origin_mm"
                raise InputError(
                    f"takes the tip out of the {side} image, at {place.round(3).tolist()} mm of "
                    "the stage",
                    field=f"experiment.{field}",
                    remedy="move the needle or its origin, or shorten the stroke",
                )
