from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from stored_crops import crop

from simtip.simulation import Simulation, simulate


@pytest.fixture(scope="session")
def simulated():
    """Simulate a scene's crop, once for all tests."""

    @cache
    def simulation(path: Path) -> Simulation:
        return simulate(crop(path), seed=1)

    return simulation
