"""An experiment worked out: its sweeps in a folder, and what was measured."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.experiment.series import START, TIP, Series, Shot, shot_of
from simtip.geometry import Array
from simtip.light_inputs import light_digest
from simtip.output_folder import write_atomically
from simtip.recalibration import recalibrated
from simtip.rig_file import read_rig, write_rig
from simtip.seeding import seed32
from simtip.spec import SceneSpec
from simtip.spec.experiment import OWN_SETUP
from simtip.spec.recalibration import RecalibrationSpec
from simtip.sweep.assignment import Scenes
from simtip.sweep.campaign import Means, carry_out, prepare
from simtip.sweep.plan import Plan, noise_asked
from simtip.sweep.stage_keys import digest_of
from simtip.sweep.table import OK, Table
from simtip.version import __version__

HEAD = "experiment.json"
SWEEPS, RIGS = "sweeps", "rigs"

UNREFINED = "not_refined"
"""Status of a tip that was triangulated, but not refined as the scene asks."""

Said = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Measured:
    """What was measured in one series.

    Attributes
    ----------
    series
        What was driven.
    tip_mm
        (runs, positions, 3) world, mm; NaN where no tip was measured.
    status
        (runs, positions) of each measurement.
    counts
        How often each stage was worked out now.
    """

    series: Series
    tip_mm: Array
    status: NDArray[np.object_]
    counts: Counter[str]

    @property
    def ok(self) -> NDArray[np.bool_]:
        """Where a tip was measured, (runs, positions)."""
        return np.asarray(self.status == OK)


def perform(
    scene: SceneSpec,
    planned: Sequence[Series],
    seed: int,
    out: Path,
    means: Means,
    *,
    allowed: tuple[str, ...] = (),
    retry_failed: bool = False,
    said: Said = lambda _: None,
) -> list[Measured]:
    """Work out an experiment's series, or go on with them.

    Parameters
    ----------
    scene
        With its experiment.
    planned
        Its series, see `simtip.experiment.series.series_of`.
    seed
        Root of all random numbers.
    out
        Folder of the experiment.
    means
        What works on it.
    allowed
        A detector that is a program or a module, which the caller is willing to run.
    retry_failed
        Whether measurements that failed are tried again.
    said
        Told what is begun.

    Raises
    ------
    InputError
        A set-up does not fit the scene, or the folder cannot be written.
    KeyboardInterrupt
        The same call goes on.
    """
    shared = _shared_light(scene, planned, [one.sweep(scene, seed).base for one in planned])
    plans = [
        _plan(scene, one, seed, out / RIGS, lit_for, allowed)
        for one, lit_for in zip(planned, shared, strict=True)
    ]
    found = []
    with closing(means.pool()) as pool:
        for number, (one, plan) in enumerate(zip(planned, plans, strict=True)):
            said(f"{one.name}: {len(plan)} measurements")
            folder = out / SWEEPS / f"{number:02d}"
            make_folder(folder.parent)
            setup = prepare(plan, means)
            tally = carry_out(plan, setup, folder, means, retry_failed=retry_failed, shared=pool)
            found.append(_measured(one, plan, folder, tally.counts))
    return found


def begin(out: Path, scene: SceneSpec, seed: int, made_by: str) -> None:
    """See that a folder is an analysis's own, `alone` in it, and take away what is out of date.

    Parameters
    ----------
    out
        The folder.
    scene, seed
        What is analysed.
    made_by
        The command.

    Raises
    ------
    InputError
        It holds something else, or cannot be written.
    """
    head = out / HEAD
    own = {HEAD, SWEEPS, RIGS}
    strangers = refuse_strangers(out, made_by)
    there = _head_of(head)
    data = {"made_by": made_by, "seed": seed, "scene": json.loads(scene.model_dump_json())}
    if there is not None and there != data:
        for name in strangers:
            if name not in own and (out / name).is_file():
                (out / name).unlink()
    write_atomically(head, json.dumps(data, indent=1).encode())


def refuse_strangers(out: Path, made_by: str) -> list[str]:
    """Refuse a folder that is not this command's own; give what is in it.

    Raises
    ------
    InputError
        It holds something else, or cannot be read.
    """
    try:
        names = sorted(one.name for one in out.iterdir() if one.name[0] != ".")
    except FileNotFoundError:
        return []
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror})", file=out, remedy="name another folder"
        ) from error
    there = _head_of(out / HEAD)
    if (names and there is None) or (there or {}).get("made_by", made_by) != made_by:
        said = names[0] if there is None else str(there["made_by"])
        raise InputError(f"holds something else ({said})", file=out, remedy="name another folder")
    return names


def _head_of(head: Path) -> dict[str, Any] | None:
    """Read what a folder says of itself; None if it says nothing that is an analysis's."""
    try:
        data = json.loads(head.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return data if isinstance(data, dict) and "made_by" in data else None


def make_folder(folder: Path) -> None:
    """Make a folder, with those around it.

    Raises
    ------
    InputError
        It cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"cannot be written ({error.strerror})", file=folder, remedy="name another folder"
        ) from error


def _shared_light(
    scene: SceneSpec, planned: Sequence[Series], bases: Sequence[SceneSpec]
) -> list[dict[str, Any]]:
    """Say what the light of every series is rendered for, so that set-ups share it where they can.

    The set-up that asks for the least noise decides, of all with the same light.
    """
    digests, noise = [light_digest(base) for base in bases], [noise_asked(base) for base in bases]
    fields = Scenes(scene)
    found: list[dict[str, Any]] = []
    for series, digest in zip(planned, digests, strict=True):
        alike = [k for k, other in enumerate(digests) if other == digest]
        strictest = min(alike, key=lambda k: noise[k])
        own = {path: fields.value(path) for path in series.changes}
        asked = {**own, **planned[strictest].changes}
        found.append({} if asked == dict(series.changes) else asked)
    return found


def _plan(
    scene: SceneSpec,
    series: Series,
    seed: int,
    rigs: Path,
    render_for: Mapping[str, Any],
    allowed: tuple[str, ...],
) -> Plan:
    """Plan a series' sweep, with a rig calibrated anew if that is asked for.

    It is kept in a file that is named by what it depends on: the last bits of least squares may
    differ from one time to the next, and measurements with them.
    """
    plan = series.sweep(scene, seed, render_for=render_for, allowed=allowed)
    # What is not calibrated anew is measured with the rig of the scene as it is.
    how, seen, name = series.calibration, plan.base, series.name
    if how is None:
        how, seen, name = scene.experiment.calibration, scene, OWN_SETUP
    if how is None:
        return plan
    own = seed32(seed, "experiment", name, "calibration", how.seed)
    rig = _kept_rig(rigs, whole_sensors(seen), how.model_copy(update={"seed": own}))
    path = str(rig.absolute())
    return series.sweep(scene, seed, rig=path, render_for=render_for, allowed=allowed)


def _kept_rig(rigs: Path, whole: SceneSpec, how: RecalibrationSpec) -> Path:
    """Give the file of a rig, calibrated now if it is not there or damaged."""
    told = [part.model_dump(mode="json") for part in (how, whole.rig, whole.boards)]
    rig = rigs / f"{digest_of([__version__, *told, whole.needle.tip_mm])[:24]}.json"
    try:
        read_rig(rig)
    except InputError:
        make_folder(rigs)
        write_rig(rig, recalibrated(whole, how))
    return rig


def whole_sensors(scene: SceneSpec) -> SceneSpec:
    """Give the scene with all of both sensors read out: a calibration board needs the room."""
    cameras = {side: getattr(scene.rig, side) for side in ("left", "right")}
    whole = {side: one.model_copy(update={"roi": None}) for side, one in cameras.items()}
    return scene.model_copy(update={"rig": scene.rig.model_copy(update=whole)})


def _measured(series: Series, plan: Plan, folder: Path, counts: Counter[str]) -> Measured:
    """Bring a table's rows back into the order of the runs."""
    rows = Table.open(folder).by_trial()
    refines = plan.base.refine.name != "none"
    shots, shot, turn = series.shots()
    by_turn: dict[tuple[Shot, int], dict[str, Any]] = {}
    for number in range(len(plan)):
        trial = plan.trial(number)
        start = trial.values.get(START, shots[0][1])
        by_turn[shot_of(trial.values[TIP], start), trial.repeat] = rows[number]
    tips = np.full((*shot.shape, 3), np.nan)
    status = np.full(shot.shape, "", dtype=object)
    for index in np.ndindex(shot.shape):
        row = by_turn[shots[shot[index]], int(turn[index])]
        status[index] = row["status"]
        if row["status"] == OK and refines and row["refined_norm_mm"] is None:
            status[index] = UNREFINED
        elif row["status"] == OK:
            tips[index] = [row[f"tip_{axis}_mm"] for axis in "xyz"]
    return Measured(series, tips, status, Counter(counts))
