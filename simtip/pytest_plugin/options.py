"""What may be said to the plug-in on pytest's command line and by its marker."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

MARKER = (
    "simtip(suite=..., cases=[...], repeats=N): which suite, which of its cases, and how many "
    "pairs of each condition a test that asks for simtip_suite gets."
)

USUAL_ARTIFACTS = ".simtip-failures"
"""Folder of pictures, in the root folder of the tests."""


def add_options(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("simtip", "needle tips against their truth (simtip)")
    group.addoption(
        "--simtip-suite",
        metavar="SUITE",
        type=not_empty,
        help="Suite of tests that ask for simtip_suite and name none (default: standard).",
    )
    group.addoption(
        "--simtip-seed",
        metavar="N",
        type=int,
        help="Draw the sensors' noise of every pair anew; by default it is always the same.",
    )
    group.addoption(
        "--simtip-cache",
        metavar="DIR",
        type=not_empty,
        help="Folder of renders and images (default: SIMTIP_CACHE, or the user's own cache).",
    )
    group.addoption(
        "--simtip-backend",
        metavar="NAME",
        type=not_empty,
        help="auto, cuda, llvm or scalar (default: SIMTIP_BACKEND, or auto).",
    )
    group.addoption(
        "--simtip-artifacts",
        metavar="DIR",
        type=not_empty,
        help=f"Folder of pictures of failed tests (default: {USUAL_ARTIFACTS} in the root folder).",
    )


def not_empty(said: str) -> str:
    """Refuse nothing, such as of a variable that is not set: it would be the working folder."""
    if not said.strip():
        raise argparse.ArgumentTypeError("is empty; name something, or leave it out")
    return said


def chosen(config: pytest.Config, name: str) -> str | None:
    """Give what an option says, such as ``--simtip-suite``; None if it is not given."""
    said: object = config.getoption(name.removeprefix("--").replace("-", "_"))
    return None if said is None else str(said)


def chosen_seed(config: pytest.Config) -> int | None:
    """Give the seed of the noise; None if it is not given.

    Raises
    ------
    InputError
        It is out of range.
    """
    said = chosen(config, "--simtip-seed")
    if said is None:
        return None
    from simtip.pytest_plugin.seeds import require_seed

    return require_seed(int(said), "--simtip-seed")


def artifacts_folder(config: pytest.Config) -> Path:
    """Give the folder of pictures of failed tests."""
    said = chosen(config, "--simtip-artifacts")
    if said is None:
        return config.rootpath / USUAL_ARTIFACTS
    return config.invocation_params.dir / said
