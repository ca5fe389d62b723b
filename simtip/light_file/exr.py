"""OpenEXR files of several parts: named float channels, each part in a window of one frame."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

UNREADABLE = (RuntimeError, ValueError, KeyError, OSError, MemoryError)
"""What reading a file that is none may raise."""


@dataclass(frozen=True)
class Window:
    """A rectangle of the frame, px."""

    left: int
    top: int
    width: int
    height: int

    @property
    def shape(self) -> tuple[int, int]:
        """Give (height, width)."""
        return self.height, self.width

    def bounds(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Give the first and the last pixel, (x, y) each, as OpenEXR has them."""
        last = self.left + self.width - 1, self.top + self.height - 1
        return np.array([self.left, self.top], np.int32), np.array(last, np.int32)

    @classmethod
    def within(cls, bounds: Any) -> Window:
        """Make one from the first and the last pixel, (x, y) each."""
        (left, top), (right, bottom) = ([int(x) for x in corner] for corner in bounds)
        return cls(left, top, right - left + 1, bottom - top + 1)


@dataclass(frozen=True, eq=False)
class Part:
    """Channels of one window, each of its shape."""

    window: Window
    channels: dict[str, Floats]
    packed: bool = False
    """To be compressed; that is not known of a part that was read."""


@dataclass(frozen=True)
class Head:
    """What a part's header says."""

    name: str
    window: Window
    attributes: dict[str, Any]


def write_parts(path: Path, parts: dict[str, Part], attributes: dict[str, str]) -> None:
    """Write a file; the first part fills the frame and carries the attributes.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    import OpenEXR

    frame = next(iter(parts.values())).window
    made: list[Any] = []
    for name, part in parts.items():
        header = {
            "type": OpenEXR.scanlineimage,
            "compression": OpenEXR.ZIP_COMPRESSION if part.packed else OpenEXR.NO_COMPRESSION,
            "displayWindow": frame.bounds(),
            "dataWindow": part.window.bounds(),
            **({} if made else attributes),
        }
        made.append(OpenEXR.Part(header, part.channels, name))
    with OpenEXR.File(made) as file:
        try:
            file.write(str(path))
        except RuntimeError as error:  # so it reports a full disk
            raise OSError(str(error).replace(str(path), path.name)) from error


def read_heads(path: Path) -> list[Head]:
    """Read the headers of all parts; raises one of `UNREADABLE` where there are none."""
    import OpenEXR

    with _hushed(), OpenEXR.File(str(path), header_only=True) as file:
        heads = []
        for k, part in enumerate(file.parts):
            header = dict(file.header(k))  # which is emptied on closing
            heads.append(Head(str(part.name()), Window.within(header["dataWindow"]), header))
    if not heads:
        raise ValueError("without parts")
    return heads


def read_parts(path: Path, heads: list[Head]) -> dict[str, Part]:
    """Read the pixels of all parts; raises one of `UNREADABLE` if one cannot be had whole."""
    import OpenEXR

    windows = {head.name: head.window for head in heads}
    found = {}
    with _hushed(), OpenEXR.File(str(path), separate_channels=True) as file:
        for k, part in enumerate(file.parts):
            name = str(part.name())
            channels = {layer: channel.pixels for layer, channel in file.channels(k).items()}
            found[name] = Part(windows[name], channels)
    lost = [name for name in windows if name not in found]  # OpenEXR passes over damaged parts
    if lost:
        raise ValueError(f"part {lost[0]} is damaged")
    return found


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
