from __future__ import annotations

import pytest

from simtip.sweep.cache import Cache


@pytest.fixture
def cache(tmp_path) -> Cache:
    """An empty one, whose folder does not exist yet."""
    return Cache(tmp_path / "cache")
