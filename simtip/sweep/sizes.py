"""Sizes of data as people write and read them."""

from __future__ import annotations

import re

from simtip.errors import InputError

USUAL_SIZE = "20GB"
"""Of a cache."""

SIZE_OPTION = "--cache-size"
UNITS = ("B", "kB", "MB", "GB", "TB")
SIZE = re.compile(r"\s*([0-9]{1,15})(?:\.([0-9]{1,9}))?\s*(?:([kmgt])(i?))?b\s*", re.IGNORECASE)


def parse_size(text: str) -> int:
    """Read a size such as ``20GB`` or ``1.5 GiB``.

    Parameters
    ----------
    text
        A number and its unit: B, kB, MB, GB, TB or kiB, MiB, GiB, TiB, in small letters or large.

    Returns
    -------
    int
        Bytes; what a fraction leaves of a byte is dropped.

    Raises
    ------
    InputError
        It is something else.
    """
    if text == "0":
        return 0
    found = SIZE.fullmatch(text)
    if found is None:
        raise InputError(
            f"{text!r} is no size", field=SIZE_OPTION, remedy="write it like 20GB or 512MiB"
        )
    whole, fraction, prefix, binary = found.groups(default="")
    unit: int = (1024 if binary else 1000) ** " kmgt".index(prefix.lower() or " ")
    parts: int = 10 ** len(fraction)
    return int(whole + fraction) * unit // parts


def shown_size(n: int) -> str:
    """Give bytes as people read them, three digits: ``1.53 GB``."""
    size, unit = float(n), UNITS[0]
    for unit in UNITS:
        if size < 999.5 or unit == UNITS[-1]:
            break
        size /= 1000
    return f"{size:.3g} {unit}" if size < 999.5 else f"{size:.0f} {unit}"
