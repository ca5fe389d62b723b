"""An experiment worked out: its sweeps in a folder, and what was measured."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
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
from simtip.rig_file import write_rig
from simtip.seeding import seed32
from simtip.spec import SceneSpec
from simtip.spec.experiment import OWN_SETUP
from simtip.sweep.assignment import Scenes
from simtip.sweep.campaign import Means, carry_out, prepare
from simtip.sweep.plan import Plan, noise_asked
from simtip.sweep.stage_keys import digest_of
from simtip.sweep.table import OK, Table
from simtip.version import __version__

HEAD = "experiment.json"
SWEEPS, RIGS = "sweeps", "rigs"

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
    for number, (one, plan) in enumerate(zip(planned, plans, strict=True)):
        said(f"{one.name}: {len(plan)} measurements")
        folder = out / SWEEPS / f"{number:02d}"
        folder.parent.mkdir(parents=True, exist_ok=True)
        tally = carry_out(plan, prepare(plan, means), folder, means, retry_failed=retry_failed)
        found.append(_measured(one, plan, folder, tally.counts))
    return found


def begin(out: Path, scene: SceneSpec, seed: int) -> None:
    """Make an experiment's folder, or see that it is one.

    Raises
    ------
    InputError
        It holds something else, or cannot be written.
    """
    head = out / HEAD
    try:
        out.mkdir(parents=True, exist_ok=True)
        strangers = sorted(entry.name for entry in out.iterdir() if entry.name[0] != ".")
    except OSError as error:
        raise InputError(
            f"cannot be written ({error.strerror})", file=out, remedy="name another folder"
        ) from error
    if strangers and not head.exists():
        raise InputError(
            f"holds something else ({strangers[0]})", file=out, remedy="name another folder"
        )
    data = {"seed": seed, "scene": json.loads(scene.model_dump_json())}
    write_atomically(head, json.dumps(data, indent=1).encode())


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
    how = series.calibration
    if how is None:
        return plan
    setup = series.name if series.is_setup else OWN_SETUP
    own = seed32(seed, "experiment", setup, "calibration", how.seed)
    whole, how = whole_sensors(plan.base), how.model_copy(update={"seed": own})
    told = [part.model_dump(mode="json") for part in (how, whole.rig, whole.boards)]
    rig = rigs / f"{digest_of([__version__, *told, whole.needle.tip_mm])[:24]}.json"
    if not rig.exists():
        rigs.mkdir(parents=True, exist_ok=True)
        write_rig(rig, recalibrated(whole, how))
    path = str(rig.absolute())
    return series.sweep(scene, seed, rig=path, render_for=render_for, allowed=allowed)


def whole_sensors(scene: SceneSpec) -> SceneSpec:
    """Give the scene with all of both sensors read out: a calibration board needs the room."""
    cameras = {side: getattr(scene.rig, side) for side in ("left", "right")}
    whole = {side: one.model_copy(update={"roi": None}) for side, one in cameras.items()}
    return scene.model_copy(update={"rig": scene.rig.model_copy(update=whole)})


def _measured(series: Series, plan: Plan, folder: Path, counts: Counter[str]) -> Measured:
    """Bring a table's rows back into the order of the runs."""
    rows = Table.open(folder).by_trial()
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
        if row["status"] == OK:
            tips[index] = [row[f"tip_{axis}_mm"] for axis in "xyz"]
    return Measured(series, tips, status, Counter(counts))
