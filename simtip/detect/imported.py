"""Detectors named ``package.module:function``."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from operator import attrgetter
from pathlib import Path

from simtip.detect.adopted import adopted
from simtip.detect.foreign_code import ForeignCodeError, foreign_code
from simtip.detect.guarded import GuardedDetector
from simtip.detect.parameters import FIELD_PREFIX, nearest
from simtip.errors import InputError

FIELD = f"{FIELD_PREFIX}.name"


def imported_detector(reference: str) -> GuardedDetector:
    """Import the detector that ``package.module:function`` names.

    The module may also lie in the current folder, which is searched first, but for this import
    alone. The function may be an object with the `Detector` protocol, and ``a.b`` after the colon
    the part b of the object a.

    Raises
    ------
    InputError
        There is no such module or function, the module fails while it is imported, or what is
        found there is no detector.
    """
    module_name, _, path = reference.partition(":")
    parts = [*module_name.split("."), *path.split(".")]
    if not all(part.isidentifier() for part in parts):
        raise InputError(
            f"{reference!r} is not package.module:function",
            field=FIELD,
            remedy="write e.g. mydetectors.edges:find, or 'cmd:...' for a program",
        )
    try:
        with _current_folder_first(), foreign_code():
            module = importlib.import_module(module_name)
    except ForeignCodeError as error:
        raise _import_error(module_name, error) from error
    try:
        with foreign_code():
            found = attrgetter(path)(module)
    except ForeignCodeError as error:
        known = [name for name, value in vars(module).items() if callable(value)]
        public = [name for name in known if not name.startswith("_")]
        raise InputError(
            f"the module {module_name} has no {path!r}",
            field=FIELD,
            remedy=nearest(path, public) if public else "name a function of it",
        ) from error
    try:
        with foreign_code():
            return adopted(reference, found)
    except ForeignCodeError as error:
        raise InputError(
            f"{reference} cannot be used: {error}", field=FIELD, remedy="mend the detector"
        ) from error


def _import_error(module: str, error: ForeignCodeError) -> InputError:
    cause = error.__cause__
    missing = cause.name if isinstance(cause, ModuleNotFoundError) else None
    # The module itself is not there, not one that it imports.
    if missing is not None and (module == missing or module.startswith(f"{missing}.")):
        return InputError(
            f"there is no module {missing!r}",
            field=FIELD,
            remedy="run simtip in the folder that holds it, or install it",
        )
    return InputError(
        f"the module {module} cannot be imported: {error}", field=FIELD, remedy="mend it"
    )


@contextmanager
def _current_folder_first() -> Iterator[None]:
    folder = str(Path.cwd())
    importlib.invalidate_caches()  # the file may be a moment old
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        if folder in sys.path:  # the module may have changed it
            sys.path.remove(folder)
