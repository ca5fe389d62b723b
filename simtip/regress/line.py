"""A line of a result in words, and how lists and p-values are written in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

MOST_NAMED = 4
"""Conditions that are named in one line."""


@dataclass(frozen=True)
class Line:
    """A line of the result.

    Attributes
    ----------
    state, kind
        See `simtip.regress.change`; the kind may be ``time`` or ``images``, too.
    where
        Names of the conditions; none is all.
    text
        In words.
    """

    state: str
    kind: str
    where: tuple[str, ...]
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Give plain values."""
        return {
            "state": self.state,
            "kind": self.kind,
            "where": list(self.where),
            "text": self.text,
        }


def few(parts: Sequence[str]) -> str:
    """List some of many things."""
    more = len(parts) - MOST_NAMED
    text = "; ".join(parts[:MOST_NAMED])
    return f"{text}; and {more} more" if more > 0 else text


def p_text(p: float) -> str:
    """Write a p-value."""
    return f"p = {p:.1g}" if p >= 1e-12 else "p < 1e-12"
