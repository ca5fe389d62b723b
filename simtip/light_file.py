"""A view's light groups on disk: one multi-layer OpenEXR file, enough to go on from.

Layers: ``lamp.<name>.R/G/B`` radiance per unit radiance of each lamp, ``ambient.R/G/B`` likewise,
``mask.needle`` and ``mask.clutter`` 0 to 1, ``Z`` camera z in mm, ``samples`` per pixel (0: not
sampled on its own), ``noise.<group>`` its Monte-Carlo standard deviation where samples is 0, and
``covariance.<i>.<j>`` of groups i <= j where it is not. The attribute ``simtip`` holds JSON: the
format, the version, the side, the seed, the back end and the whole scene.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from simtip.errors import InputError
from simtip.render.backend import VARIANTS
from simtip.render.noise import Noise
from simtip.render.view import View
from simtip.spec import SceneSpec
from simtip.version import __version__

ATTRIBUTE = "simtip"
FORMAT = 1
AMBIENT = "ambient"
MAX_PIXELS = 100_000_000
REMEDY = "give a file that `simtip render --lights` wrote"

Floats = NDArray[np.float32]
Channels = dict[str, Floats]


@dataclass(frozen=True, eq=False)
class Lights:
    """One view's light groups and where they came from.

    Attributes
    ----------
    view
        As it was rendered.
    spec
        The scene it was rendered from.
    seed
        The root seed it was rendered with.
    side
        "left" or "right".
    """

    view: View
    spec: SceneSpec
    seed: int
    side: str


def lights_name(side: str) -> str:
    """Name a view's file in a folder of results."""
    return f"{side}_lights.exr"


def write_lights(path: Path, lights: Lights) -> None:
    """Write a view's light groups.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    import OpenEXR

    about = {
        "format": FORMAT,
        "version": __version__,
        "side": lights.side,
        "seed": lights.seed,
        "backend": lights.view.backend,
        "lamps": list(lights.view.lamps),
        "scene": lights.spec.model_dump(mode="json"),
    }
    header = {
        "compression": OpenEXR.ZIPS_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "comments": "radiance per unit radiance of each lamp; Z: camera z, mm",
        ATTRIBUTE: json.dumps(about),
    }
    with OpenEXR.File(header, _channels(lights.view)) as file:
        try:
            file.write(str(path))
        except RuntimeError as error:  # so it reports a full disk
            raise OSError(str(error).replace(str(path), path.name)) from error


def _channels(view: View) -> Channels:
    channels: Channels = {}
    for name, response in zip(view.lamps, view.response, strict=True):
        for k, colour in enumerate("RGB"):
            channels[f"{_layer(name)}.{colour}"] = np.ascontiguousarray(response[..., k])
    channels |= {"mask.needle": view.coverage, "mask.clutter": view.clutter, "Z": view.depth_mm}
    noise, shape = view.noise, view.coverage.shape
    samples = np.zeros(shape, np.float32)
    samples.reshape(-1)[noise.pixels] = noise.samples
    channels["samples"] = samples
    for i, name in enumerate(view.lamps):
        channels[f"noise.{name}"] = np.ascontiguousarray(noise.open_sd[i])
        for j in range(i, len(view.lamps)):
            covariance = np.zeros(shape, np.float32)
            covariance.reshape(-1)[noise.pixels] = noise.covariance[:, i, j]
            channels[f"covariance.{i}.{j}"] = covariance
    return channels


def _layer(lamp: str) -> str:
    return lamp if lamp == AMBIENT else f"lamp.{lamp}"


def read_lights(path: Path) -> Lights:
    """Read a view's light groups.

    Raises
    ------
    InputError
        The file is missing, is no such file, or is damaged.
    """
    import OpenEXR

    if not path.is_file():
        raise InputError("no such file", file=path, remedy=REMEDY)
    try:
        with _hushed(), OpenEXR.File(str(path), header_only=True) as file:
            header = dict(file.header())  # which is emptied on closing
        about, shape = _about(header), _shape(header)
        with _hushed(), OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: channel.pixels for name, channel in file.channels().items()}
    except InputError as error:
        raise InputError(error.problem, file=path, remedy=REMEDY) from error
    except (RuntimeError, ValueError, OSError, MemoryError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"is no readable OpenEXR file ({reason})", file=path, remedy=REMEDY
        ) from error
    try:
        spec = SceneSpec.model_validate_json(json.dumps(about["scene"]), strict=True)
        return Lights(_view(channels, about, shape), spec, int(about["seed"]), str(about["side"]))
    except (KeyError, TypeError, ValueError, ValidationError) as error:
        what = str(error).splitlines()[0]
        raise InputError(
            f"is damaged or of another version ({what})", file=path, remedy=REMEDY
        ) from error


@contextmanager
def _hushed() -> Iterator[None]:
    """Keep OpenEXR from writing its own complaints to standard output and error."""
    kept = os.dup(2)
    try:
        with Path(os.devnull).open("wb") as nowhere, redirect_stdout(io.StringIO()):
            os.dup2(nowhere.fileno(), 2)
            yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def _about(header: dict[str, Any]) -> dict[str, Any]:
    text = header.get(ATTRIBUTE)
    try:
        about = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        about = None
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise InputError(f"holds no light groups of format {FORMAT}")
    lamps = about.get("lamps")
    if not isinstance(lamps, list) or lamps[-1:] != [AMBIENT] or len(set(map(str, lamps))) > 256:
        raise InputError("names no light groups")
    return about


def _shape(header: dict[str, Any]) -> tuple[int, int]:
    low, high = header["dataWindow"]
    width, height = (int(b) - int(a) + 1 for a, b in zip(low, high, strict=True))
    if not 0 < width * height <= MAX_PIXELS:
        raise InputError(f"has {width}x{height} px, and {MAX_PIXELS} pixels is the limit")
    return height, width


def _view(channels: dict[str, Any], about: dict[str, Any], shape: tuple[int, int]) -> View:
    def channel(name: str) -> Floats:
        pixels = channels[name]
        if pixels.shape != shape or pixels.dtype != np.float32:
            raise ValueError(f"channel {name} is {pixels.dtype} of {pixels.shape}")
        return np.asarray(pixels)

    if about["backend"] not in VARIANTS.values():
        raise ValueError(f"the back end {about['backend']!r} is unknown")
    lamps = tuple(str(name) for name in about["lamps"])
    response = np.empty((len(lamps), *shape, 3), np.float32)
    for k, name in enumerate(lamps):
        for c, colour in enumerate("RGB"):
            response[k, ..., c] = channel(f"{_layer(name)}.{colour}")
    samples = channel("samples").reshape(-1)
    pixels = np.flatnonzero(samples).astype(np.uint32)
    covariance = np.empty((len(pixels), len(lamps), len(lamps)), np.float32)
    for i in range(len(lamps)):
        for j in range(i, len(lamps)):
            values = channel(f"covariance.{i}.{j}").reshape(-1)[pixels]
            covariance[:, i, j] = covariance[:, j, i] = values
    noise = Noise(
        np.stack([channel(f"noise.{name}") for name in lamps]),
        pixels,
        covariance,
        samples[pixels].astype(np.uint32),
    )
    return View(
        lamps=lamps,
        response=response,
        coverage=channel("mask.needle"),
        clutter=channel("mask.clutter"),
        depth_mm=channel("Z"),
        noise=noise,
        backend=str(about["backend"]),
    )
