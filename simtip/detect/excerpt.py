"""What others wrote, cut short and made printable for a line of ours."""

from __future__ import annotations

LIMIT = 200


def excerpt(text: str, limit: int = LIMIT) -> str:
    """Give the text in one line, without control characters, at most about `limit` characters.

    Of a long text the beginning and the end are kept: what failed is often said last.
    """
    line = " ".join(text.split())
    if len(line) > limit:
        head = limit // 3
        line = f"{line[:head]} ... {line[head + 5 - limit :]}"
    return printable(line)


def printable(text: str) -> str:
    """Show what a terminal might obey, or cannot show, as the escape that Python has for it."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
