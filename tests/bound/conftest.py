from __future__ import annotations

import pytest
from regions import with_roi


@pytest.fixture(scope="session")
def tip_scene(scene):
    """The paper's set-up, read out where the needle's cone ends."""
    return with_roi(scene, [796, 840, 50, 50], [1006, 838, 50, 50], noise=None, samples=64)
