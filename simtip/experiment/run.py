"""An experiment from its scene to its result."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simtip.experiment.analysis import analyse
from simtip.experiment.files import write_result, write_rows
from simtip.experiment.performed import Said, begin, perform, refuse_strangers
from simtip.experiment.result import CAMERA, Capability
from simtip.experiment.series import series_of
from simtip.spec import SceneSpec
from simtip.sweep.campaign import Means
from simtip.sweep.resuming import alone

MADE_BY = "simtip mca"


@dataclass(frozen=True, eq=False)
class Experiment:
    """An experiment and what came of it.

    Attributes
    ----------
    scene, seed
        What was tried, and the root of its random numbers.
    capability
        What it says of the measuring system.
    counts
        How often each stage was worked out now.
    frame
        In which positions are told: "camera", or "stage" as it was registered.
    """

    scene: SceneSpec
    seed: int
    capability: Capability
    counts: Counter[str]

    frame: str = CAMERA

    def to_dict(self) -> dict[str, Any]:
        """Give plain values: the keys of ``mca --json``."""
        worked = {name: self.counts.get(name, 0) for name in ("light", "images", "measure")}
        return {
            "scene": self.scene.name,
            "seed": self.seed,
            "detector": self.scene.detect.name,
            "setups": [one.series.name for one in self.capability.measured],
            "worked_out": worked,
            **self.capability.to_dict(self.frame),
        }


def run_experiment(
    scene: SceneSpec,
    out: Path,
    means: Means | None = None,
    *,
    seed: int | None = None,
    allowed: tuple[str, ...] = (),
    retry_failed: bool = False,
    frame: str = CAMERA,
    said: Said = lambda _: None,
) -> Experiment:
    """Run a scene's experiment, or go on with it.

    Parameters
    ----------
    scene
        With its `experiment`.
    out
        Folder of the results: sweeps, calibrated rigs, ``mca.json`` and ``measurements.csv``.
    means
        What works on it.
    seed
        Root of all random numbers; by default the scene's.
    allowed
        A detector that is a program or a module, which the caller is willing to run.
    retry_failed
        Whether measurements that failed are tried again.
    frame
        In which positions are told: "camera", or "stage" as it is registered.
    said
        Told what is begun.

    Raises
    ------
    InputError
        Something in the scene does not fit, the folder cannot be written, too few tips were
        measured, or no frame of the stage was found.
    KeyboardInterrupt
        The same call goes on.
    """
    seed = scene.seed if seed is None else seed
    planned = series_of(scene, seed)
    refuse_strangers(out, MADE_BY)
    with alone(out):
        begin(out, scene, seed, MADE_BY)
        measured = perform(
            scene,
            planned,
            seed,
            out,
            means or Means(),
            allowed=allowed,
            retry_failed=retry_failed,
            said=said,
        )
        axes = scene.experiment.stage.axes(scene.needle.axis)
        capability = analyse(scene.experiment, measured, axes)
        counts = sum((one.counts for one in measured), Counter[str]())
        made = Experiment(scene, seed, capability, counts, frame)
        told = made.to_dict()
        write_rows(out, capability)
        write_result(out, told)
    return made
