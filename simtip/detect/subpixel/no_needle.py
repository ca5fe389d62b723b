"""What is said where there is no needle."""

from __future__ import annotations

from simtip.detect.observation import TipStatus


class NoNeedleError(Exception):
    """A candidate is no needle, or its tip cannot be measured; the text says why."""

    def __init__(self, status: TipStatus, reason: str) -> None:
        super().__init__(reason)
        self.status = status
        self.reason = reason
