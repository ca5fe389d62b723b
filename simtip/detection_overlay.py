"""Pictures to judge single detections by: the tip marked, and the detector's own layers."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from simtip.detection import Detection
from simtip.image_file import write_png
from simtip.overlay import draw_view, layer_picture

MAX_STEM_BYTES = 100


class OverlayWriter:
    """Writes the pictures of one image after the other into a folder, under names of their own.

    Parameters
    ----------
    folder
        An existing one.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._stems: set[str] = set()
        self._files: set[str] = set()

    def write(self, seen: Detection) -> None:
        """Write ``NAME_overlay.png``, and ``NAME_LAYER.png`` for each layer, made small."""
        stem = _unused(_plain(seen.file.stem), self._stems)
        observation = seen.observation
        white_dn = float(max(1, seen.image.max())) if seen.image.dtype.itemsize > 1 else None
        picture = draw_view(
            seen.image,
            title=seen.file.name,
            tip_detected_px=observation.tip_px,
            axis_detected_px=observation.axis_px,
            reason=observation.reason or None,
            white_dn=white_dn,
        )
        self._save(f"{stem}_overlay", picture)
        for name, layer in observation.layers.items():
            shown = layer_picture(layer)
            if shown is not None:
                self._save(f"{stem}_{_plain(name)}", shown)

    def _save(self, name: str, picture: NDArray[np.uint8]) -> None:
        write_png(self._folder / f"{_unused(name, self._files)}.png", picture)


def _unused(name: str, taken: set[str]) -> str:
    """Give the name, or with a number one that is not taken yet on any file system; take it."""
    found, count = name, 1
    while found.casefold() in taken:
        count += 1
        found = f"{name}_{count}"
    taken.add(found.casefold())
    return found


def _plain(name: str) -> str:
    """Keep letters, digits and a few signs; whatever else a name holds becomes ``_``."""
    safe = re.sub(r"[^\w.+ -]", "_", name) or "_"
    return safe.encode("utf-8", "replace")[:MAX_STEM_BYTES].decode("utf-8", "ignore")
