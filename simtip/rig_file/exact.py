"""Numbers as text that every reader turns back into the same float."""

from __future__ import annotations

from collections.abc import Iterable


def exact(number: float) -> str:
    """Write a finite number in the fewest digits that read back to the same float."""
    text = repr(float(number))
    mantissa, e, exponent = text.partition("e")
    # YAML 1.1, which Kalibr and many ROS scripts follow, takes 1e-05 for text, but not 1.0e-05.
    return f"{mantissa}.0e{exponent}" if e and "." not in mantissa else text


def listed(numbers: Iterable[float]) -> str:
    """Write numbers with commas between them."""
    return ", ".join(exact(number) for number in numbers)
