"""Numbers as the page writes them; lengths below 0.1 mm in micrometres."""

from __future__ import annotations

import math

from simtip.report.scale import MINUS, digits, scale_for

NONE = "\N{EN DASH}"


def length(value: float | None) -> str:
    """Write a length, mm, with three digits."""
    if value is None or not math.isfinite(value):
        return NONE
    return scale_for([value]).text(value)


def lengths(*values: float | None) -> list[str]:
    """Write lengths, mm, in one unit and with as many decimals."""
    known = [value for value in values if value is not None and math.isfinite(value)]
    scale = scale_for(known or [0.0])
    return [
        NONE if value is None or not math.isfinite(value) else scale.text(value) for value in values
    ]


def interval(value: float, ends: list[float | None] | None) -> str:
    """Write an interval around a length, mm, without its unit; nothing if there is none."""
    if ends is None:
        return ""
    scale = scale_for([value, *(end for end in ends if end is not None)])
    low, high = (NONE if end is None else scale.number(end) for end in ends)
    return f"[{low}, {high}] {scale.unit}"


def signed(value: float | None, unit: str, decimals: int = 2) -> str:
    """Write a number with its sign."""
    if value is None or not math.isfinite(value):
        return NONE
    rounded = round(value, decimals) + 0.0
    return f"{rounded:+.{decimals}f} {unit}".replace("-", MINUS).replace("+0.00 ", "0.00 ")


def percent(share: float | None, decimals: int = 1) -> str:
    """Write a share of 1 in per cent; 100 % and 0 % only where they are exact."""
    if share is None or not math.isfinite(share):
        return NONE
    if share in (0.0, 1.0):
        return f"{100 * share:.0f} %"
    least = 10.0**-decimals
    return f"{min(max(100 * share, least), 100 - least):.{decimals}f} %"


def count(number: int) -> str:
    """Write a number with its thousands apart."""
    return f"{number:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def figure(value: float | None, least_digits: int = 3) -> str:
    """Write a number without unit, with three digits."""
    if value is None or not math.isfinite(value):
        return NONE
    if value == 0:
        return "0"
    decimals = digits(abs(value)) if abs(value) < 10**least_digits else 0
    return f"{value:.{decimals}f}".replace("-", MINUS)
