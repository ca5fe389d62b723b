"""A folder of `simtip sweep`: the images of its trials, from the cache or made again.

Trials that look at the same images are one pair with several readings. Nothing here runs a
detector, so a table that names a program starts none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from simtip.errors import InputError, SimtipError
from simtip.geometry import Array
from simtip.image_sets.pairs import SIDES, Cell, NeedlePair, Reading
from simtip.render import Backend, choose
from simtip.render.backend import VARIANTS
from simtip.sensor import Image
from simtip.spec import SceneSpec
from simtip.spec.scene import DetectSpec
from simtip.sweep.assignment import Scenes
from simtip.sweep.cache import Cache
from simtip.sweep.columns import FIXED
from simtip.sweep.conditions import filtered
from simtip.sweep.frames import plain
from simtip.sweep.head import HEAD
from simtip.sweep.limit import Limit
from simtip.sweep.plan import Plan, Trial
from simtip.sweep.rows import cell_of
from simtip.sweep.shots import read_shot
from simtip.sweep.spec import RangeSpec, SweepSpec
from simtip.sweep.stages import IMAGES, Stages
from simtip.sweep.table import OK, Table
from simtip.sweep.varying import DETECT, NOT_RENDERED
from simtip.truth import SceneTruth

Row = dict[str, Any]

AGREE_MM = 1e-6
"""How far a trial's true tip may be from what its row says of it."""

AGAIN = "run the sweep again with this simtip, then export"

ENDLESS_S = 1e9

OWN = ("trial", "repeat", "noise_seed", "detector")


@dataclass(frozen=True)
class Store:
    """Where images of sweeps are looked for, and what renders those that are not there.

    Attributes
    ----------
    cache
        None for none.
    backend
        Name of what renders; None is what the sweep was rendered with.
    """

    cache: Cache | None = None
    backend: str | None = None


class SweepImages:
    """Pairs of images that a sweep's trials looked at, in order of the trials.

    Parameters
    ----------
    folder
        Of the sweep.
    where
        Conditions that trials have to meet, see `simtip.sweep.conditions`.
    store
        Where images are looked for.

    Raises
    ------
    InputError
        There is no table, it is damaged, a condition is none, or no trial that meets them has
        images.
    """

    def __init__(self, folder: Path, where: Sequence[str], store: Store) -> None:
        self.source = str(folder)
        self._folder, self._store = folder, store
        table = Table.open(folder)
        fixed = [column.name for column in FIXED]
        table.require(fixed)
        self._factors = tuple(c.name for c in table.columns if c.name not in fixed)
        self.settings = (*OWN, *self._factors)
        chosen = filtered(table.numbered(), where)
        there = chosen["image_key"].notna()
        self.without_images: Mapping[str, int] = Counter(chosen.loc[~there, "status"])
        self._rows = chosen.loc[there].reset_index(drop=True)
        keys = self._rows["image_key"]
        self._groups = list(self._rows.groupby(keys, sort=False).indices.values())
        self._groups.sort(key=lambda numbers: int(numbers[0]))
        if not self._groups:
            raise InputError(
                "no trial that is asked for has images",
                file=folder,
                remedy="see `simtip results`" if where else "let the sweep go on",
            )
        self._sweep, self._scene = self._provenance(table)

    def __len__(self) -> int:
        """Give the number of pairs."""
        return len(self._groups)

    def pairs(self) -> Iterator[NeedlePair]:
        """Give them one by one; InputError where one is not in the cache and cannot be made."""
        for numbers in self._groups:
            part = self._rows.iloc[numbers]
            columns = [plain(part[name]) for name in part.columns]
            rows = [dict(zip(part.columns, row, strict=True)) for row in zip(*columns, strict=True)]
            yield self._pair(rows)

    def _pair(self, rows: list[Row]) -> NeedlePair:
        first = rows[0]
        values = self._values(first)
        setting = self._stages.setting(self._trial(first, values))
        for row in rows:
            self._require_agreement(row, setting.truth)
        images = self._images(first, values, setting.images)
        readings = tuple(self._reading(row, setting.truth) for row in rows)
        label = f"trial {first['trial']}"
        return NeedlePair(self.source, label, readings[0].spec, setting.truth, images, readings)

    def _images(self, row: Row, values: Mapping[str, Any], key: str) -> tuple[Image, Image]:
        wanted, cache = str(row["image_key"]), self._store.cache
        try:
            kept = None if cache is None else cache.entry(IMAGES, wanted)
        except ValueError as error:
            raise InputError(
                f"trial {row['trial']} has {wanted[:80]!r}, which is no key of images",
                file=self._folder,
                field="image_key",
                remedy=AGAIN,
            ) from error
        shot = None if kept is None else read_shot(kept)
        if shot is not None:
            return shot.images
        if key != wanted:
            raise InputError(
                f"the images of trial {row['trial']} are not in the cache, and this simtip, or "
                "what it renders with, would make others",
                file=self._folder,
                remedy=f"name the cache by --cache, or {AGAIN}",
            )
        return self._stages.shot(self._trial(row, values)).images

    def _trial(self, row: Row, values: Mapping[str, Any]) -> Trial:
        return Trial(int(row["trial"]), values, int(row["repeat"]), self._plan.detectors[0], {})

    def _values(self, row: Row, *, all_of_scene: bool = False) -> dict[str, Any]:
        """Give the values of the scene's fields in a trial that its images may depend on."""
        names = [name for name in self._factors if not name.startswith(DETECT)]
        if not all_of_scene:
            names = [name for name in names if not name.startswith(NOT_RENDERED)]
        return {name: self._value(name, row[name]) for name in names}

    def _value(self, name: str, cell: Any) -> Any:
        """Give the value that a cell was written from: parts and lists are text there."""
        if not isinstance(cell, str):
            return cell
        known = self._levels.get(name, {})
        if cell not in known:
            raise InputError(
                f"holds {cell[:80]!r}, which is no level of the sweep",
                file=self._folder,
                field=name,
                remedy="run the sweep again: its table and its sweep file differ",
            )
        return known[cell]

    @cached_property
    def _levels(self) -> dict[str, dict[object, Any]]:
        listed = {p: v for p, v in self._sweep.factors.items() if not isinstance(v, RangeSpec)}
        for group in self._sweep.zipped:
            listed |= group
        return {path: {cell_of(v, "text"): v for v in values} for path, values in listed.items()}

    @cached_property
    def _plan(self) -> Plan:
        """The sweep without what comes after its images."""
        late = (DETECT, *NOT_RENDERED)

        def early(part: Mapping[str, Any]) -> dict[str, Any]:
            return {path: one for path, one in part.items() if not path.startswith(late)}

        zipped = [early(group) for group in self._sweep.zipped]
        sweep = self._sweep.model_copy(
            update={
                "factors": early(self._sweep.factors),
                "zipped": [group for group in zipped if group],
                "detectors": None,
            }
        )
        rig = self._scene.rig.model_copy(update={"measured": None})
        scene = self._scene.model_copy(update={"rig": rig, "detect": DetectSpec()})
        return Plan(sweep, scene)

    @cached_property
    def _stages(self) -> Stages:
        return Stages(self._plan, self._store.cache, self._backend(), Limit(ENDLESS_S))

    def _backend(self) -> Backend:
        """Give what the sweep was rendered with, even where it does not work: keys depend on it."""
        named = self._store.backend or self._renders_with
        try:
            return choose(named)
        except SimtipError:
            known = next((name for name in VARIANTS if name == named), None)
            if self._store.backend is not None or known is None:
                raise
            return Backend(known, "as the sweep was")

    def _provenance(self, table: Table) -> tuple[SweepSpec, SceneSpec]:
        said = table.provenance
        try:
            self._renders_with: str = said["backend"]
            return (
                SweepSpec.model_validate_json(said["sweep"], strict=True),
                SceneSpec.model_validate_json(said["scene"], strict=True),
            )
        except (KeyError, TypeError, ValidationError) as error:
            raise InputError(
                "does not say of which sweep and scene it is, or of another version's",
                file=self._folder / HEAD,
                remedy=AGAIN,
            ) from error

    def _reading(self, row: Row, truth: SceneTruth) -> Reading:
        settings: dict[str, Cell] = {name: row[name] for name in self.settings}
        tips = [
            _added(view.tip_px, [row[f"{side}_error_{axis}_px"] for axis in "uv"])
            for side, view in zip(SIDES, (truth.left, truth.right), strict=True)
        ]
        place = [row[f"tip_{axis}_mm"] for axis in "xyz"]
        return Reading(
            detector=str(row["detector"]),
            status=str(row["status"]),
            reason=str(row["reason"] or ""),
            tips_px=(tips[0], tips[1]),
            tip_mm=None if None in place else np.array(place, dtype=np.float64),
            spec=self._full.with_values(self._values(row, all_of_scene=True)),
            settings=settings,
        )

    @cached_property
    def _full(self) -> Scenes:
        return Scenes(self._scene)

    def _require_agreement(self, row: Row, truth: SceneTruth) -> None:
        """Refuse a row that was scored against another truth than this simtip finds."""
        if row["status"] != OK:
            return
        tip, error = (
            np.array([row[name.format(axis)] for axis in "xyz"], dtype=np.float64)  # None is NaN
            for name in ("tip_{}_mm", "error_{}_mm")
        )
        if not float(np.abs(tip - error - truth.tip_mm).max()) <= AGREE_MM:
            raise InputError(
                f"trial {row['trial']} was scored against another tip than this simtip finds",
                file=self._folder,
                remedy=AGAIN,
            )


def _added(true_px: Array, error_px: list[float | None]) -> Array | None:
    """Give where a tip was detected: its error is measured - true."""
    if None in error_px:
        return None
    detected: Array = true_px + np.array(error_px, dtype=np.float64)
    return detected
