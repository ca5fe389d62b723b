"""Which layer of a light file holds what of a view, there and back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from simtip.light_file.exr import Floats, Part, Window
from simtip.mix import AMBIENT
from simtip.render.noise import Noise
from simtip.render.view import View

PARTS = ("light", "scene", "noise", "sampled")


def to_parts(view: View) -> dict[str, Part]:
    """Give a view's layers, by part."""
    height, width = view.coverage.shape
    frame = Window(0, 0, width, height)
    light = {
        f"{_layer(name)}.{colour}": np.ascontiguousarray(response[..., k])
        for name, response in zip(view.lamps, view.response, strict=True)
        for k, colour in enumerate("RGB")
    }
    scene = {"mask.needle": view.coverage, "mask.clutter": view.clutter, "Z": view.depth_mm}
    noise = {f"noise.{name}": sd for name, sd in zip(view.lamps, view.noise.open_sd, strict=True)}
    return {
        "light": Part(frame, light),
        "scene": Part(frame, scene, packed=True),
        "noise": Part(frame, noise),
        "sampled": _sampled(view.noise, frame),
    }


def _sampled(noise: Noise, frame: Window) -> Part:
    window = _around(noise.pixels, frame)
    rows, columns = np.divmod(noise.pixels.astype(np.intp), frame.width)
    places = rows - window.top, columns - window.left

    def plane(values: NDArray[np.generic]) -> Floats:
        filled = np.zeros(window.shape, np.float32)
        filled[places] = values
        return filled

    channels = {"samples": plane(noise.samples)}
    for i, j in _pairs(noise.covariance.shape[-1]):
        channels[_covariance(i, j)] = plane(noise.covariance[:, i, j])
    return Part(window, channels, packed=True)


def _around(pixels: NDArray[np.uint32], frame: Window) -> Window:
    """Give the least window around pixels, and one pixel if there are none: OpenEXR needs one."""
    if not len(pixels):
        return Window(0, 0, 1, 1)
    rows, columns = np.divmod(pixels.astype(np.intp), frame.width)
    left, top = int(columns.min()), int(rows.min())
    return Window(left, top, int(columns.max()) - left + 1, int(rows.max()) - top + 1)


def to_view(parts: dict[str, Part], lamps: Sequence[str], backend: str) -> View:
    """Put a view together again.

    Raises
    ------
    ValueError
        A part or a layer is missing, a layer is no float32 of its part's shape, or a part is not
        where it should be.
    """
    lost = [name for name in PARTS if name not in parts]
    if lost:
        raise ValueError(f"part {lost[0]} is missing")
    frame = parts["light"].window
    if frame != Window(0, 0, frame.width, frame.height):
        raise ValueError("part light does not fill the frame")
    for name in ("scene", "noise"):
        if parts[name].window != frame:
            raise ValueError(f"part {name} does not fill the frame")
    response = np.empty((len(lamps), *frame.shape, 3), np.float32)
    for k, name in enumerate(lamps):
        for c, colour in enumerate("RGB"):
            response[k, ..., c] = _plane(parts["light"], f"{_layer(name)}.{colour}")
    return View(
        lamps=tuple(lamps),
        response=response,
        coverage=_plane(parts["scene"], "mask.needle"),
        clutter=_plane(parts["scene"], "mask.clutter"),
        depth_mm=_plane(parts["scene"], "Z"),
        noise=_noise(parts, lamps, frame),
        backend=backend,
    )


def _noise(parts: dict[str, Part], lamps: Sequence[str], frame: Window) -> Noise:
    sampled = parts["sampled"]
    window = sampled.window
    inside = 0 <= window.left <= frame.width - window.width
    if not inside or not 0 <= window.top <= frame.height - window.height:
        raise ValueError("part sampled leaves the frame")
    samples = _plane(sampled, "samples")
    places = np.nonzero(samples)
    pixels = (places[0] + window.top) * frame.width + places[1] + window.left
    covariance = np.empty((len(pixels), len(lamps), len(lamps)), np.float32)
    for i, j in _pairs(len(lamps)):
        values = _plane(sampled, _covariance(i, j))[places]
        covariance[:, i, j] = covariance[:, j, i] = values
    return Noise(
        np.stack([_plane(parts["noise"], f"noise.{name}") for name in lamps]),
        pixels.astype(np.uint32),
        covariance,
        samples[places].astype(np.uint32),
    )


def _plane(part: Part, name: str) -> Floats:
    pixels = part.channels.get(name)
    if pixels is None:
        raise ValueError(f"channel {name} is missing")
    if pixels.shape != part.window.shape or pixels.dtype != np.float32:
        raise ValueError(f"channel {name} is {pixels.dtype} of {pixels.shape}")
    return pixels


def _layer(lamp: str) -> str:
    return lamp if lamp == AMBIENT else f"lamp.{lamp}"


def _pairs(groups: int) -> list[tuple[int, int]]:
    return [(i, j) for i in range(groups) for j in range(i, groups)]


def _covariance(i: int, j: int) -> str:
    return f"covariance.{i}.{j}"
