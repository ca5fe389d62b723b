"""A sweep's folder: made anew, gone on with, or brought to a changed sweep file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.sweep.columns import Column, Row, columns_for
from simtip.sweep.durable import TEMPORARY
from simtip.sweep.head import HEAD, ROWS_FOLDER
from simtip.sweep.plan import Plan
from simtip.sweep.rows import factor_cells
from simtip.sweep.table import OK, Table

LOCK = ".lock"

BATCH = 20_000


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Keep other sweeps out of a folder within the block; a killed one leaves it free.

    Raises
    ------
    InputError
        Another is at work in it, or it cannot be made or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise InputError(
            f"cannot be written ({error.strerror})", file=folder, remedy="name another folder"
        ) from error
    try:
        if not _locked(descriptor):
            raise InputError(
                "another sweep is at work in it", file=folder, remedy="wait, or name another folder"
            )
        yield
    finally:
        os.close(descriptor)


def _locked(descriptor: int) -> bool:
    try:
        import fcntl
    except ImportError:  # no such thing on this system
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def open_table(
    folder: Path, plan: Plan, provenance: dict[str, Any], code: str = "", *, retry_failed: bool
) -> tuple[Table, NDArray[np.bool_]]:
    """Give the table of a sweep, and which trials of the plan are in it.

    Rows of a sweep file that has changed meanwhile are kept as far as they are still asked for.

    Parameters
    ----------
    folder
        Of the sweep; `alone` in it.
    plan
        What is asked for.
    provenance
        What the table says of itself, besides the plan.
    code
        That rows are made by; trials whose rows are of another count as not done.
    retry_failed
        Whether trials that failed count as not done.

    Raises
    ------
    InputError
        The folder holds something else, or cannot be written.
    OSError
        The disk is full.
    """
    columns = columns_for(Column(name, kind) for name, kind in plan.columns())
    about = {**provenance, "plan": plan.digest, "trials": len(plan)}
    if not (folder / HEAD).exists():
        check_folder(folder)
        return Table.create(folder, columns, about), np.zeros(len(plan), np.bool_)
    table = Table.open(folder)
    if table.provenance.get("plan") != plan.digest or table.columns != columns:
        _bring_over(table, plan, columns, about)
    return table, _done(table, len(plan), code, retry_failed=retry_failed)


def check_folder(folder: Path) -> None:
    """Refuse what is there and is no folder of a sweep; nothing is written.

    Raises
    ------
    InputError
        It is a file, or a folder that holds something else.
    """
    if (folder / HEAD).exists() or not os.path.lexists(folder):
        return
    try:
        strangers = [entry.name for entry in folder.iterdir() if not _is_own(entry)]
    except OSError as error:
        raise InputError(
            f"cannot be a sweep's folder ({error.strerror})",
            file=folder,
            remedy="name another folder",
        ) from error
    if strangers:
        raise InputError(
            f"holds something else ({strangers[0]})", file=folder, remedy="name another folder"
        )


def rows_of(folder: Path) -> int:
    """Give how many rows a sweep's folder has; 0 where there is none."""
    return len(Table.open(folder).keys()) if (folder / HEAD).exists() else 0


def _is_own(entry: Path) -> bool:
    """Say whether a killed sweep may have left it before there was a table."""
    if entry.name == LOCK or entry.name.startswith(TEMPORARY):
        return True
    return ROWS_FOLDER.fullmatch(entry.name) is not None and not any(entry.iterdir())


def _done(table: Table, trials: int, code: str, *, retry_failed: bool) -> NDArray[np.bool_]:
    done = np.zeros(trials, np.bool_)
    for rows in table.batches():
        for row in rows:
            number = row["trial"]
            if isinstance(number, int) and 0 <= number < trials:
                right = row["status"] == OK or not retry_failed
                done[number] = right and row["code"] == code
    return done


def _bring_over(
    table: Table, plan: Plan, columns: tuple[Column, ...], about: dict[str, Any]
) -> None:
    """Keep the rows that the changed plan still asks for, under their new numbers."""
    old = {str(row["key"]): row for rows in table.batches() for row in rows}
    names = {column.name for column in columns}
    kinds = dict(plan.columns())

    def kept() -> Iterator[list[Row]]:
        batch: list[Row] = []
        for number in range(len(plan)) if old else ():
            trial = plan.trial(number)
            row = old.get(plan.key(trial))
            if row is not None:
                same = {name: value for name, value in row.items() if name in names}
                batch.append({**same, "trial": number, **factor_cells(trial, kinds)})
            if len(batch) >= BATCH:
                yield batch
                batch = []
        if batch:
            yield batch

    table.rewrite(columns, kept(), about)


def as_json(plan: Plan) -> tuple[str, str]:
    """Give a plan's sweep and scene as JSON, to make it again elsewhere."""
    spec = plan.spec.model_copy(update={"base": {}})
    # What is unset has to stay so: a preset fills it up.
    return spec.model_dump_json(by_alias=True), plan.base.model_dump_json(exclude_unset=True)
