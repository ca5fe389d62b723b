"""What a plain scalar means: the core schema of YAML 1.2.2, section 10.3.2."""

from __future__ import annotations

import math
import re

MAX_NUMBER_LENGTH = 300
"""Longest number, in characters: any integer of that length still fits a float."""

INT = re.compile(r"[-+]?[0-9]+\Z")
OCTAL = re.compile(r"0o[0-7]+\Z")
HEX = re.compile(r"0x[0-9a-fA-F]+\Z")
FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?\Z")

_WORDS: dict[str, float | bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **{sign + word: math.inf for sign in ("", "+") for word in (".inf", ".Inf", ".INF")},
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -math.inf),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan),
}
_NOT_TEXT = re.compile(
    "[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"
)


def plain_value(text: str) -> str | float | bool | None:
    """Give a plain scalar its value.

    Raises
    ------
    ValueError
        It is a number too long or too large.
    """
    if text in _WORDS:
        return _WORDS[text]
    if not any(pattern.match(text) for pattern in (INT, OCTAL, HEX, FLOAT)):
        return text
    if len(text) > MAX_NUMBER_LENGTH:
        raise ValueError(f"a number of {len(text)} characters is too long")
    if INT.match(text):
        return int(text)
    if OCTAL.match(text) or HEX.match(text):
        return int(text, 0)
    number = float(text)
    if math.isinf(number):
        raise ValueError(f"the number {text[:40]} is too large")
    return number


def control_character(text: str) -> tuple[int, str] | None:
    """Find the first character that YAML does not allow: its place, and its name ``U+0007``."""
    bad = _NOT_TEXT.search(text)
    return None if bad is None else (bad.start(), f"U+{ord(bad.group()):04X}")
