"""What a reader may ask of a page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simtip.bound import KnownBound

PICTURES = 10
"""Of the worst trials."""


@dataclass(frozen=True)
class Options:
    """What a reader may ask of a page.

    Attributes
    ----------
    pictures
        Worst trials of a sweep that are shown.
    limit_mm
        Of the error, where the operating envelope begins; None is a round number near the median.
    bound
        The least error that any method can have on the scene, for efficiency.
    cache
        Folder of renders and images; None is the user's own.
    backend
        What renders images that are not in the cache; None is the best there is.
    progress
        Told the fraction of the pictures done.
    """

    pictures: int = PICTURES
    limit_mm: float | None = None
    bound: KnownBound | None = None
    cache: Path | None = None
    backend: str | None = None
    progress: Callable[[float], None] = lambda _: None
