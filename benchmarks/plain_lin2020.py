"""The plain composition of the steps of lin2020, as the tests have it to compare with."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

from simtip.detect import TipObservation

ORACLE = Path(__file__).resolve().parents[1] / "tests" / "oracles" / "lin2020_oracle.py"


def _oracle() -> Any:
    spec = importlib.util.spec_from_file_location("lin2020_oracle", ORACLE)
    if spec is None or spec.loader is None:
        raise SystemExit(f"{ORACLE.name} is missing: run this in a checkout with its tests")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_ORACLE = _oracle()


def plain_steps(image: Any) -> TipObservation:
    """Detect the tip with the paper's parameters, each step on the whole image."""
    observation: TipObservation = _ORACLE.detect(image)
    return observation
