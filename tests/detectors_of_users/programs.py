"""Small programs that play an external detector, and pictures for them."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import numpy as np

GRAY = np.arange(12 * 20, dtype=np.uint8).reshape(12, 20)
TIP = '{"tip_px": [3.25, 4.5]}'


def program(folder: Path, body: str, arguments: str = "{image}", name: str = "program.py") -> str:
    """Write a Python program; give the reference that runs it."""
    file = folder / name
    file.write_text(f"import json, os, signal, sys, time\n{body}\n", encoding="utf-8")
    # -I -S: isolated and without site-packages, so that it starts quickly.
    words = shlex.join([sys.executable, "-I", "-S", str(file)])
    return f"cmd:{words} {arguments}"


def saying(folder: Path, text: str) -> str:
    """Give the reference of a program that writes a text to its standard output."""
    return program(folder, f"sys.stdout.write({text!r})")
