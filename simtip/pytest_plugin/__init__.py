"""The pytest plug-in: pairs of images with their truth for tests, and pictures where they fail.

pytest loads this wherever it is installed beside simtip, whether a test needs it or not. So
nothing but pytest is imported here; the rest is when a test first asks for a pair.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING

import pytest

from simtip.pytest_plugin.options import MARKER, add_options
from simtip.pytest_plugin.stashed import USED

if TYPE_CHECKING:
    from simtip.pytest_plugin.case import PairsOfCase
    from simtip.pytest_plugin.factory import PairFactory


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    add_options(parser)


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marker."""
    config.addinivalue_line("markers", MARKER)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Let a test that asks for ``simtip_suite`` run once a case."""
    if "simtip_suite" in metafunc.fixturenames:
        from simtip.pytest_plugin.selection import parametrize

        parametrize(metafunc)


@pytest.fixture
def simtip_pair(request: pytest.FixtureRequest) -> PairFactory:
    """Make pairs of images with their truth: simtip_pair(scene, seed=None, changes=None)."""
    from simtip.pytest_plugin.factory import factory_for

    return factory_for(request)


@pytest.fixture
def simtip_suite(request: pytest.FixtureRequest) -> PairsOfCase:
    """Give the pairs of images of one case of a suite after the other; a test runs once a case."""
    from simtip.pytest_plugin.case import case_for

    return case_for(request)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Attach pictures of the pairs of a test that has failed; at its end let go of its images."""
    report = yield
    used = item.stash.get(USED, None)
    if used is not None and report.failed:
        from simtip.pytest_plugin.pictures import attach

        attach(item, report, used)
    if used is not None and call.when == "teardown":
        del item.stash[USED]
    return report
