"""Folders that one process of the tests makes and all of them use, which may not change them."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from simtip.sweep.locked_file import flock


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Give a folder of this session's, made by whichever process of pytest-xdist comes first.

    Parameters
    ----------
    factory
        The session's.
    name
        Of the folder.
    make
        Fills it; it is empty.
    """
    own = factory.getbasetemp()
    base = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "made_once"
    base.mkdir(exist_ok=True)
    folder, done = base / name, base / f"{name}.done"
    with (base / f"{name}.lock").open("wb") as lock:
        flock(lock.fileno(), wait=True)
        if not done.exists():
            shutil.rmtree(folder, ignore_errors=True)  # of one that failed
            folder.mkdir()
            make(folder)
            done.touch()
    return folder
