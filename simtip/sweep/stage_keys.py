"""What a stage's result depends on, as one key: inputs, the stage's code, what it runs on.

Light comes first, images depend on its key, measurements on theirs. So a threshold changes the
measurement's key alone, a lamp's power also the images', a pose all three.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import itertools
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from simtip.camera import StereoRig
from simtip.detect import names_code
from simtip.detect.dithered import PREFIX as DITHERED
from simtip.detect.registry import listing
from simtip.light_inputs import light_inputs
from simtip.spec import SceneSpec
from simtip.version import __version__

PACKAGE = Path(__file__).resolve().parents[1]

BOTH = ("camera", "geometry", "lens", "undistort", "seeding", "errors", "yaml_file")
SCENE = ("spec", "presets", "needle", "spectra", "flicker", "silhouette", "footprint", "truth")
SENSOR = ("sensor", "exposure", "optics", "psf", "mix")
LIGHT = (*BOTH, *SCENE, *SENSOR, "render", "clutter", "noise_budget", "light_inputs", "light_file")
IMAGES = (*BOTH, *SCENE, *SENSOR, "simulation", "render/view")
MEASURE = (
    *BOTH,
    *("detect", "match", "correspondence", "triangulate", "refine", "measure", "measuring_rig"),
    *("rig_file", "score", "trial"),
    *("sweep/rows", "sweep/detectors", "sweep/stages", "sweep/shots"),
)
"""Modules and packages of simtip that a stage's result depends on."""

RUNS_ON = {
    "light": (
        *("mitsuba", "drjit", "karellen-llvm-core", "numpy", "scipy", "trimesh"),
        *("opencv-python-headless", "OpenEXR"),
    ),
    "images": ("numpy", "scipy", "opencv-python-headless"),
    "measure": ("numpy", "scipy", "opencv-python-headless"),
}
"""Libraries of which every version may give other bits."""

NOT_IN_IMAGES = {"name", "detect", "match", "triangulate", "refine", "boards", "experiment"}

UNJUDGED = {"start_s", "row_time_s", "noise"}
"""Of the sensor: noise is judged by lamps without their ripple, and as if it were switched on."""

NOT_OWN = {"__pycache__", "site-packages", "node_modules"}

MOST_FILES = 5000
"""Of a detector's own package, that are looked at for changes."""


def light_key(spec: SceneSpec, variant: str) -> str:
    """Give the key of a scene's rendered light.

    Parameters
    ----------
    spec
        The scene as it is rendered. If it asks for little noise, how little depends on its sensor
        and its lamps' powers, too.
    variant
        What renders.
    """
    asked = None if spec.render.noise is None else _noise_inputs(spec)
    inputs = {"light": light_inputs(spec), "asked": asked, "variant": variant}
    return _digest("light", LIGHT, inputs)


def _noise_inputs(spec: SceneSpec) -> dict[str, Any]:
    """Give the part of a scene that says how little noise its light may have."""
    data = spec.model_dump(mode="json")
    apertures = [
        [camera["lens"][name] for name in ("f_number", "focal_length_mm", "focus_mm")]
        for camera in (data["rig"]["left"], data["rig"]["right"])
    ]
    kept = {name: data[name] for name in ("sensor", "lamps", "ambient")}
    kept["sensor"] = {key: value for key, value in data["sensor"].items() if key not in UNJUDGED}
    return {**kept, "noise": data["render"]["noise"], "apertures": apertures}


def image_inputs(spec: SceneSpec) -> dict[str, Any]:
    """Give the part of a scene that its images depend on, as plain data."""
    data = spec.model_dump(mode="json")
    rig = {key: value for key, value in data["rig"].items() if key != "measured"}
    kept = {key: value for key, value in data.items() if key not in NOT_IN_IMAGES}
    return {**kept, "rig": rig}


def image_key(light: str, inputs: Mapping[str, Any], seed: int) -> str:
    """Give the key of a pair of images.

    Parameters
    ----------
    light
        Of the rendered light.
    inputs
        See `image_inputs`.
    seed
        Of the sensors' noise.
    """
    return _digest("images", IMAGES, {"light": light, "inputs": inputs, "seed": seed})


def measure_key(images: str, spec: SceneSpec, rig: StereoRig) -> str | None:
    """Give the key of a measurement.

    Parameters
    ----------
    images
        Key of the images.
    spec
        The scene, its detector and parameters as they are used.
    rig
        That measures.

    Returns
    -------
    key
        None for a detector of which nobody can know whether it has changed: an external program.
    """
    detector = detector_code(spec.detect.name)
    if detector is None:
        return None
    return _digest(
        "measure",
        MEASURE,
        {
            "images": images,
            "detect": spec.detect.model_dump(mode="json"),
            "code": detector,
            "match": spec.match.model_dump(mode="json"),
            "triangulate": spec.triangulate.model_dump(mode="json"),
            "refine": spec.refine.model_dump(mode="json"),
            "bit_depth": spec.sensor.bit_depth,
            "rig": None if spec.rig.measured is None else rig_digest(rig),
        },
    )


def rig_digest(rig: StereoRig) -> str:
    """Tell a rig from any other by its numbers, whatever files they come from."""
    cameras = [
        [camera.K.tolist(), list(camera.distortion), list(camera.size)]
        for camera in (rig.left, rig.right)
    ]
    return digest_of([cameras, rig.T_lr.R.tolist(), rig.T_lr.t.tolist()])


def code_digest(references: Iterable[str], variant: str) -> str:
    """Tell all code that trials run on from any other: simtip's, libraries', detectors'."""
    stages = [_stage_code(*stage) for stage in (("light", LIGHT), ("images", IMAGES))]
    detectors = [[reference, detector_code(reference)] for reference in sorted(references)]
    return digest_of([*stages, _stage_code("measure", MEASURE), variant, detectors])[:16]


def digest_of(data: Any) -> str:
    """Give the SHA-256, in hexadecimal, of plain data."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


@cache
def detector_code(reference: str) -> str | None:
    """Tell a detector's code from any other's; None for an external program.

    A plug-in or an imported module is told by all Python files of its package, or of its folder; so
    is a dithered one, since how it is dithered is simtip's own code.
    """
    reference = reference.removeprefix(DITHERED)
    if reference.startswith("cmd:"):
        return None
    if not names_code(reference):
        found = listing(reference)
        if found.source == "built in":
            return ""  # its code is simtip's own
        module = _module_of(found.source)
    else:
        module = reference.partition(":")[0]
    return _package_digest(module)


def _module_of(source: str) -> str:
    """Find the module in what the registry says of a plug-in: "... (package.module:name)"."""
    return source.rpartition("(")[2].rstrip(")").partition(":")[0]


def _package_digest(module: str) -> str | None:
    spec = importlib.util.find_spec(module.partition(".")[0])
    if spec is None or spec.origin is None or not Path(spec.origin).is_file():
        return None
    # A module that stands alone may import what lies beside it.
    folder = Path(spec.origin).parent
    files = list(itertools.islice(_python_files(folder), MOST_FILES + 1))
    return None if len(files) > MOST_FILES else _files_digest(sorted(files), folder)


def _python_files(folder: Path) -> Iterator[Path]:
    """Give the Python files of a folder and of those in it, but for environments and the like."""
    for place, inner, names in os.walk(folder):
        inner[:] = [name for name in inner if name[0] != "." and name not in NOT_OWN]
        yield from (Path(place) / name for name in names if name.endswith(".py"))


def _digest(stage: str, modules: tuple[str, ...], inputs: dict[str, Any]) -> str:
    return digest_of({"stage": stage, "code": _stage_code(stage, modules), **inputs})


@cache
def _stage_code(stage: str, modules: tuple[str, ...]) -> str:
    """Tell a stage's code from any other's: simtip's files, and the libraries' versions."""
    files: list[Path] = []
    for name in modules:
        place = PACKAGE / name
        files += sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    versions = {name: _version(name) for name in RUNS_ON[stage]}
    return digest_of([__version__, versions, _files_digest(files, PACKAGE)])


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:  # the system's own, perhaps
        return None


def _files_digest(files: Iterable[Path], root: Path) -> str:
    said = hashlib.sha256()
    for file in files:
        content = file.read_bytes()
        said.update(f"{file.relative_to(root).as_posix()} {len(content)}\n".encode())
        said.update(content)
    return said.hexdigest()
