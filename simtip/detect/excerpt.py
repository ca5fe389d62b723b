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
    # Codes that clear a terminal, and halves of characters that no file can hold.
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)
