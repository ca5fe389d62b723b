"""Folders of small results, and exports of them, made once for all tests."""

from __future__ import annotations

from pathlib import Path

import pytest
from asked import call
from made_once import made_once
from regions import with_roi

from simtip.output_folder import result_folder
from simtip.render import choose
from simtip.result_folder import write_manifest, write_simulation, write_trial
from simtip.spec import SceneSpec
from simtip.trial import run_trial

LEFT, RIGHT = [740, 560, 140, 360], [950, 560, 160, 360]
"""Regions with 23 mm of the needle and its tip."""

DISTORTION = {"left": [-0.12, 0.05, 0.001, -0.0008, 0.01], "right": [-0.10, 0.04, -0.0007, 0.0012]}


def small(scene: SceneSpec, **parts: object) -> SceneSpec:
    """Give the paper's scene with few pixels and samples, and other parts."""
    cut = with_roi(scene, LEFT, RIGHT, noise=None, samples=4, light_step_mm=4.0)
    data = cut.model_dump(mode="json")
    for name, part in parts.items():
        old = data[name]
        data[name] = {**old, **part} if isinstance(old, dict) and isinstance(part, dict) else part
    data["detect"] = {"name": "lin2020", "min_area_px": 1000}
    return SceneSpec.model_validate(data)


def occluded(scene: SceneSpec) -> SceneSpec:
    """Put a cable before the needle's tip in both views, and before 10 mm up in the left one."""
    return small(scene, seed=2, clutter={"level": "hostile", "occlude": True})


def distorted(scene: SceneSpec) -> SceneSpec:
    """Give both lenses distortion."""
    data = small(scene).model_dump(mode="json")
    for side, coefficients in DISTORTION.items():
        data["rig"][side]["lens"]["distortion"] = coefficients
    return SceneSpec.model_validate(data)


def run_into(folder: Path, spec: SceneSpec, *, measured: bool = True) -> Path:
    """Leave what `simtip run` leaves of a scene, or `simtip render`."""
    trial = run_trial(spec, backend=choose("llvm"))
    with result_folder(folder) as inside:
        write_simulation(inside, trial.simulation)
        if measured:
            write_trial(inside, trial)
        write_manifest(inside, trial.simulation, {})
    return folder


def run_once(
    factory: pytest.TempPathFactory, name: str, spec: SceneSpec, *, measured: bool = True
) -> Path:
    """Give such a folder, which all tests share."""
    made = made_once(factory, name, lambda f: run_into(f / "run", spec, measured=measured))
    return made / "run"


def exported(out: Path, form: str, *folders: Path, more: tuple[str, ...] = ()) -> Path:
    """Export, and see that it went well."""
    answer = call("export", *map(str, folders), "--format", form, "-o", str(out), *more)
    assert answer.code == 0, answer.err
    return out
