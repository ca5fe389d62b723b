"""One COCO file, whose images and annotations come in turns."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from simtip.export.json_stream import JsonArray
from simtip.version import __version__

ABOUT = (
    "Rendered by simtip. Keypoints: (0, 0) is the centre of the top-left pixel; boxes count from "
    "its corner. Masks: pixels whose centre shows the needle."
)


class CocoFile:
    """Takes categories, images and annotations in any order.

    Parameters
    ----------
    path
        The file; what grows meanwhile lies beside it.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._images = JsonArray(path.with_suffix(".images"))
        self._annotations = JsonArray(path.with_suffix(".annotations"))
        self._categories: list[dict[str, Any]] = []
        self._count = 0

    def __enter__(self) -> Self:
        """Begin."""
        self._images.__enter__()
        self._annotations.__enter__()
        return self

    def category(self, told: dict[str, Any]) -> None:
        """Add a category."""
        self._categories.append(told)

    def image(self, told: dict[str, Any]) -> None:
        """Add an image."""
        self._images.add(told)

    def annotation(self, told: dict[str, Any]) -> None:
        """Add an annotation, which gets the next id."""
        self._count += 1
        self._annotations.add({"id": self._count, **told})

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Put the parts together."""
        parts = {"images": self._images, "annotations": self._annotations}
        for part in parts.values():
            part.__exit__(kind, error, trace)
        if kind is not None:
            return
        info = {"description": ABOUT, "version": __version__}
        head = {"info": info, "licenses": [], "categories": self._categories}
        with self._path.open("wb") as out:
            out.write(json.dumps(head, indent=1, allow_nan=False)[:-2].encode())
            for name in parts:
                part_file = self._path.with_suffix(f".{name}")
                out.write(f',\n "{name}": '.encode())
                with part_file.open("rb") as stream:
                    shutil.copyfileobj(stream, out)
                part_file.unlink()
            out.write(b"}\n")
