"""Keys under which pytest keeps what belongs to a test or to a session."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from simtip.pytest_plugin.used import Used
    from simtip.pytest_plugin.workshop import Workshop

USED: pytest.StashKey[Used] = pytest.StashKey()
"""The pairs of a test."""

WORKSHOP: pytest.StashKey[Workshop] = pytest.StashKey()
"""What makes the pairs of a session."""
