"""What `run` and `render` leave behind: images, truth, result, and how to make them again."""

from __future__ import annotations

import datetime as dt
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.clutter import objects, objects_truth
from simtip.image_file import write_png
from simtip.light_file import Lights, lights_name, write_lights
from simtip.measuring_rig import measuring_rig
from simtip.noise_budget import noise_summary
from simtip.overlay import side_by_side
from simtip.provenance import backend_facts, environment
from simtip.render import View
from simtip.render.setting import clutter_setting
from simtip.rig_file import write_rig
from simtip.scene_file import dump_scene
from simtip.simulation import Simulation
from simtip.trial import Trial
from simtip.trial_overlay import trial_overlay

MEASURED = "rig_measured.yaml"


def write_simulation(
    folder: Path, simulation: Simulation, *, exr: bool = False, lights: bool = False
) -> None:
    """Write images, masks, truth, the resolved scene and the true rig into a folder.

    Parameters
    ----------
    folder
        An existing one.
    simulation
        What to write.
    exr
        Also the mixed radiance, coverage and depth.
    lights
        Also every light group, so that `simtip remix` can go on from there.
    """
    for side, image, view in zip(
        ("left", "right"), simulation.images, simulation.views, strict=True
    ):
        write_png(folder / f"{side}.png", image)
        write_png(folder / f"{side}_mask.png", np.rint(view.coverage * 255).astype(np.uint8))
        if view.clutter.any():
            share = np.rint(view.clutter * 255).astype(np.uint8)
            write_png(folder / f"{side}_clutter.png", share)
        if exr:
            _write_exr(folder / f"{side}.exr", view, view.radiance(simulation.spec))
        if lights:
            group = Lights(view, simulation.spec, simulation.light_seed, side)
            write_lights(folder / lights_name(side), group)
    _write_json(folder / "truth.json", _truth(simulation))
    # The light's seed: a scene rendered again from here has the same clutter.
    resolved = simulation.spec.model_copy(update={"seed": simulation.light_seed})
    if resolved.rig.measured is not None:  # the folder is complete, wherever it goes
        write_rig(folder / MEASURED, measuring_rig(resolved))
        rig = resolved.rig.model_copy(update={"measured": MEASURED})
        resolved = resolved.model_copy(update={"rig": rig})
    (folder / "scene.yaml").write_text(dump_scene(resolved), encoding="utf-8")
    write_rig(folder / "rig_true.yaml", simulation.truth.rig)


def _truth(simulation: Simulation) -> dict[str, Any]:
    """Give the truth of the needle, and of the solid clutter if there is any."""
    spec, truth = simulation.spec, simulation.truth.to_dict()
    things = objects(spec.clutter, clutter_setting(spec), simulation.light_seed)
    if things:
        truth["clutter"] = objects_truth(spec.clutter, things)
    return truth


def write_trial(folder: Path, trial: Trial) -> None:
    """Write the result and the pictures to judge it by into a simulation's folder."""
    _write_json(folder / "result.json", trial.to_dict())
    simulation = trial.simulation
    pictures = trial_overlay(
        simulation.images, simulation.truth, simulation.spec, trial.measurement
    )
    for side, picture in zip(("left", "right"), pictures, strict=True):
        write_png(folder / f"{side}_overlay.png", picture)
    write_png(folder / "overlay.png", side_by_side(*pictures))


def write_manifest(folder: Path, simulation: Simulation, timings_s: dict[str, float]) -> None:
    """Write what made the folder, and the hash of every file in it; call it last."""
    files = {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.iterdir())
    }
    _write_json(
        folder / "manifest.json",
        {
            "created_utc": dt.datetime.now(dt.UTC).isoformat(timespec="seconds"),
            **environment(),
            "backend": backend_facts(simulation.backend),
            "seed": simulation.seed,
            "light_seed": simulation.light_seed,
            "exposure_s": simulation.spec.sensor.exposure_s,
            "noise": noise_summary(simulation.spec, simulation.views),
            "timings_s": timings_s,
            "sha256": files,
        },
    )


def _write_json(path: Path, data: dict[str, Any]) -> None:
    path.write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def _write_exr(path: Path, view: View, radiance: NDArray[np.float32]) -> None:
    """Write radiance (R G B), needle coverage and depth as float channels of one OpenEXR file."""
    import OpenEXR

    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "comments": "R G B: W m^-2 sr^-1 per channel; needle: coverage; Z: camera z, mm",
    }
    channels = {
        **{name: np.ascontiguousarray(radiance[..., k]) for k, name in enumerate("RGB")},
        "needle": view.coverage,
        "Z": view.depth_mm,
    }
    with OpenEXR.File(header, channels) as file:
        try:
            file.write(str(path))
        except RuntimeError as error:  # so it reports a full disk
            raise OSError(str(error).replace(str(path), path.name)) from error
