from __future__ import annotations

import sys

import pytest
from a_users_tests import UsersTests, tiny_scene

from simtip.pytest_plugin import case, factory, pictures, selection  # noqa: F401 (see below)
from simtip.pytest_plugin.workshop import Workshop
from simtip.spec import SceneSpec
from simtip.sweep.plan import Plan
from simtip.sweep.spec import SweepSpec


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    """A cache that all tests share; in it is the tiny scene.

    A run within this process forgets the modules that it has loaded, and Mitsuba cannot be loaded
    twice: so all are loaded before. Dr.Jit replaces ``drjit.auto`` when something first looks into
    it, as pytest does for a traceback; that must not be forgotten, either.
    """
    folder = tmp_path_factory.mktemp("cache")
    scene = SceneSpec.model_validate(tiny_scene())
    plan = Plan(SweepSpec(scene="tiny"), scene)
    Workshop(None, folder, None).make(plan, plan.trial(0))
    getattr(sys.modules["drjit.auto"], "__file__", None)
    return folder


@pytest.fixture
def mine(pytester, cache, monkeypatch) -> UsersTests:
    """A user's folder of tests."""
    return UsersTests(pytester, cache, monkeypatch)
