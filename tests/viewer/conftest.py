from __future__ import annotations

from pathlib import Path

import pytest
from export.conftest import bent_lens, bevel, boards, plain  # noqa: F401 (fixtures)


@pytest.fixture
def no_display(monkeypatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture(scope="session")
def saved(tmp_path_factory) -> Path:
    """A folder for recordings."""
    return tmp_path_factory.mktemp("recordings")
