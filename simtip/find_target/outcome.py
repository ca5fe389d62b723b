"""Why a target was not found."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class NotFound:
    """The target was not found in an image.

    Attributes
    ----------
    reason
        One sentence, with what was seen instead where something was.
    """

    reason: str
