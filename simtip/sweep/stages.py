"""A trial's stages, each with a memory: light, images, measurement."""

from __future__ import annotations

import json
import time
import traceback
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from simtip.detect import ConfiguredDetector
from simtip.errors import InputError
from simtip.light_file import Lights, lights_name, read_lights, write_lights
from simtip.measuring_rig import measuring_rig
from simtip.noise_budget import noise_tolerance
from simtip.render import Backend, View, render_pair
from simtip.render.threads import limited_threads
from simtip.seeding import SEED_LIMIT
from simtip.simulation import expose_pair
from simtip.spec import SceneSpec
from simtip.sweep.cache import Cache
from simtip.sweep.leaving import ToldToLeaveError, leaving_at_once
from simtip.sweep.limit import Limit
from simtip.sweep.memory import Memory, Records
from simtip.sweep.plan import Plan, Trial
from simtip.sweep.rows import Form, failed, record_of, row_of
from simtip.sweep.shots import SIDES, Shot, read_shot, unchangeable, write_shot
from simtip.sweep.stage_keys import digest_of, image_inputs, image_key, light_key, measure_key
from simtip.trial import measured, refiner_of
from simtip.truth import SceneTruth, scene_truth

if TYPE_CHECKING:
    from simtip.camera import StereoRig
    from simtip.refine.refinement import Refiner

LIGHT, IMAGES, MEASURE = "light", "images", "measure"
"""Kinds of entries in the cache."""

INVALID, ERROR = "invalid", "error"
"""Statuses of trials that cannot be, and of those that came upon something unforeseen."""

Row = dict[str, object]


@dataclass(frozen=True, eq=False)
class Setting:
    """What the trials of one scene and repeat share.

    Attributes
    ----------
    spec
        The scene.
    truth
        What is true of it.
    light, images
        Keys.
    rendered
        The scene whose light it is.
    seed
        Of the sensors' noise.
    """

    spec: SceneSpec
    truth: SceneTruth
    light: str
    images: str
    rendered: SceneSpec
    seed: int

    @cached_property
    def rig(self) -> StereoRig:
        """The rig that measures."""
        return measuring_rig(self.spec)

    @cached_property
    def refiner(self) -> Refiner | None:
        """What refines a measurement, if anything does."""
        return refiner_of(self.spec)


class Stages:
    """Works out trials, each stage once.

    Parameters
    ----------
    plan
        The sweep's.
    cache
        Keeps what the stages make; None keeps it in memory only.
    backend
        What renders.
    limit
        Of a trial's time, without rendering.
    threads
        That the renderer may use; None leaves it as it is.
    """

    def __init__(
        self,
        plan: Plan,
        cache: Cache | None,
        backend: Backend,
        limit: Limit,
        *,
        threads: int | None = None,
    ) -> None:
        self.limit, self._threads = limit, threads
        self._plan, self._cache, self._backend = plan, cache, backend
        self._settings, self._shots, self._lights = Memory(4), Memory(2), Memory(1)
        self._detectors, self._records = Memory(1000), Memory(4)
        self._form = Form(dict(plan.columns()), plan.code(backend.variant))
        self.counts = {LIGHT: 0, IMAGES: 0, MEASURE: 0}
        """How often each stage was worked out."""

    def row(self, trial: Trial) -> Row:
        """Give a trial's row of the table; what fails is a row with its reason.

        Raises
        ------
        ToldToLeaveError
            The process was told to leave meanwhile: nothing is known of the trial.
        """
        key = self._plan.key(trial)
        try:
            setting = self.setting(trial)
            found = self._measured(trial, setting)
        except InputError as error:
            return failed(trial, key, INVALID, str(error), self._form)
        except ToldToLeaveError:
            raise
        # A detector may raise an interrupt, too: resuming would come upon it again and again.
        except (Exception, KeyboardInterrupt) as error:  # noqa: BLE001 (no trial ends the others)
            reason = "".join(traceback.format_exception_only(error)).strip()
            return failed(trial, key, ERROR, reason, self._form)
        return row_of(trial, key, setting, found, self._form)

    def light(self, trial: Trial) -> float | None:
        """See to it that a trial's light is there, and give what it took, s; None if it was."""
        setting = self.setting(trial)
        timings: dict[str, float] = {}
        if self._cache is None or self._cache.entry(LIGHT, setting.light) is None:
            self._lights.give(setting.light, lambda: self._lit(setting, timings))
        return timings.get("render_s")

    def shot(self, trial: Trial) -> Shot:
        """Give a trial's images, from the cache or made anew; nobody can change them.

        Raises
        ------
        InputError
            There is no such scene, or no exposure of it.
        """
        setting = self.setting(trial)
        return self._shots.give(setting.images, lambda: self._shot(setting, {}))

    def setting(self, trial: Trial) -> Setting:
        """Give what a trial's images are made of, their truth and keys.

        Raises
        ------
        InputError
            There is no such scene.
        """
        name = digest_of([dict(trial.values), trial.repeat])
        return self._settings.give(name, lambda: self._new_setting(trial))

    def _new_setting(self, trial: Trial) -> Setting:
        spec = self._plan.scenes.with_values(trial.values)
        truth = scene_truth(spec)
        rendered = self._plan.reference(trial)
        light = light_key(rendered, self._backend.variant)
        inputs = image_inputs(spec)
        seed = int(digest_of([self._plan.seed, inputs, trial.repeat])[:13], 16) % SEED_LIMIT
        return Setting(spec, truth, light, image_key(light, inputs, seed), rendered, seed)

    def _measured(self, trial: Trial, setting: Setting) -> Row:
        spec = setting.spec.model_copy(update={"detect": trial.measuring.spec})
        key = measure_key(setting.images, spec, setting.rig)
        own = trial.measuring.is_own
        known = self._recalled(setting.images, key)
        if known is not None:
            return known
        if self._cache is None or key is None or not own:
            # Others' detectors may read files that nobody knows of: what they measure is for this
            # sweep's repeats only.
            return self._newly_measured(trial, setting, spec, key, kept=False)
        # Of a detector that takes no notice of a factor, two workers may get the same measurement.
        with self._locked(MEASURE, key):
            known = self._recalled(setting.images, key)
            return known or self._newly_measured(trial, setting, spec, key, kept=True)

    def _newly_measured(
        self, trial: Trial, setting: Setting, spec: SceneSpec, key: str | None, *, kept: bool
    ) -> Row:
        timings: dict[str, float] = {}
        shot = self._shots.give(setting.images, lambda: self._shot(setting, timings))
        detector: ConfiguredDetector = self._detectors.give(
            digest_of([trial.measuring.identity, spec.sensor.bit_depth]),
            lambda: trial.measuring.configured(spec),
        )
        self.counts[MEASURE] += 1
        measurement, error = measured(
            shot.images, setting.truth, spec, detector, rig=setting.rig, refiner=setting.refiner
        )
        record = record_of(measurement, error, setting.truth, shot.exposure_s)
        if key is not None:
            records: Records = self._records.give(setting.images, Records)
            records.found[key] = record
        if self._cache is not None and kept:
            said = json.dumps({"key": key, "record": record}, allow_nan=False)
            self._cache.append(MEASURE, setting.images, said)
        return {**record, **timings}

    def _recalled(self, images: str, key: str | None) -> Row | None:
        if key is None:
            return None
        records: Records = self._records.give(images, Records)
        if key not in records.found and self._cache is not None:
            records.take_in(*self._cache.added_lines(MEASURE, images, records.read_bytes))
        return records.found.get(key)

    def _shot(self, setting: Setting, timings: dict[str, float]) -> Shot:
        return unchangeable(self._kept_shot(setting, timings))

    def _kept_shot(self, setting: Setting, timings: dict[str, float]) -> Shot:
        if self._cache is None:
            return self._exposed(setting, timings)
        # Two workers may get trials of the same images at once.
        with self._locked(IMAGES, setting.images):
            folder = self._cache.entry(IMAGES, setting.images)
            shot = None if folder is None else read_shot(folder)
            if shot is not None:
                return shot
            if folder is not None:
                self._cache.discard(IMAGES, setting.images)
            made = self._exposed(setting, timings)
            self._cache.put(IMAGES, setting.images, lambda folder: write_shot(folder, made))
            return made

    @contextmanager
    def _locked(self, kind: str, key: str) -> Iterator[None]:
        """Let one process at a time work out an entry; the wait is no part of a trial's time."""
        with ExitStack() as held:
            if self._cache is not None:
                with self.limit.paused():
                    held.enter_context(self._cache.lock(kind, key))
            yield

    def _exposed(self, setting: Setting, timings: dict[str, float]) -> Shot:
        with self.limit.paused():
            views = self._lights.give(setting.light, lambda: self._lit(setting, timings))
        start = time.perf_counter()
        done = expose_pair(
            setting.spec,
            views,
            seed=setting.seed,
            backend=self._backend,
            light_seed=setting.rendered.seed,
        )
        timings["sensor_s"] = time.perf_counter() - start
        self.counts[IMAGES] += 1
        return Shot(done.images, done.spec.sensor.exposure_s)

    def _lit(self, setting: Setting, timings: dict[str, float]) -> tuple[View, View]:
        if self._cache is None:
            return self._rendered(setting, timings)
        with self._cache.lock(LIGHT, setting.light):
            folder = self._cache.entry(LIGHT, setting.light)
            if folder is not None:
                try:
                    left, right = (read_lights(folder / lights_name(side)) for side in SIDES)
                except InputError:
                    self._cache.discard(LIGHT, setting.light)
                else:
                    return left.view, right.view
            return self._rendered(setting, timings)

    def _rendered(self, setting: Setting, timings: dict[str, float]) -> tuple[View, View]:
        spec = setting.rendered
        start = time.perf_counter()
        with leaving_at_once(), limited_threads(self._threads):
            views = render_pair(
                spec, backend=self._backend, seed=spec.seed, tolerance=noise_tolerance(spec)
            )
        timings["render_s"] = time.perf_counter() - start
        self.counts[LIGHT] += 1

        def write(folder: Path) -> None:
            for side, view in zip(SIDES, views, strict=True):
                write_lights(folder / lights_name(side), Lights(view, spec, spec.seed, side))

        if self._cache is not None:
            self._cache.put(LIGHT, setting.light, write)
        return views
