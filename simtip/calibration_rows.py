"""Figures of a calibration by name, as the console and the page of results show them."""

from __future__ import annotations

from typing import Any

COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")


def intrinsic(result: dict[str, Any], side: str, name: str) -> tuple[float, float]:
    """Give a parameter of a view, and its standard deviation."""
    if name in COEFFICIENTS:
        i = COEFFICIENTS.index(name)
        return result[f"D_{side}"][i], result["std"][f"D_{side}"][i]
    row, column = {"fx": (0, 0), "fy": (1, 1), "cx": (0, 2), "cy": (1, 2)}[name]
    return result[f"K_{side}"][row][column], result["std"][f"K_{side}"][row][column]


def error_of(result: dict[str, Any], name: str) -> float:
    """Give how far a parameter is from the true one."""
    return float(result["error"]["parameters"][name]["error"])
