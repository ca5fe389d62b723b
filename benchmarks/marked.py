"""Pages with a part between two marks that a command writes."""

from __future__ import annotations


def replaced(text: str, new: str, begin: str, end: str) -> str:
    """Replace what is between the marks."""
    before, _, rest = text.partition(begin)
    _, _, after = rest.partition(end)
    return f"{before}{begin}\n{new}\n{end}{after}"
