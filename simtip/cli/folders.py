"""What commands that take folders of images share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from simtip.cli.options import named

if TYPE_CHECKING:
    from simtip.image_sets import Contents

FoldersArgument = Annotated[
    list[Path], typer.Argument(parser=named, metavar="DIR...", help="Folders of results.")
]
WhereOption = Annotated[
    list[str] | None,
    typer.Option(
        "--where", metavar="CONDITION", help="Of a sweep's trials, e.g. 'repeat<5'; repeatable."
    ),
]


def opened(
    folders: list[Path], where: list[str] | None, cache: Path | None, backend: str | None
) -> Contents:
    """Open the folders.

    Raises
    ------
    InputError
        One is none, or not as it was written.
    """
    from simtip.image_sets import open_folders
    from simtip.image_sets.sweep import Store
    from simtip.sweep.cache import Cache, default_folder

    store = Store(Cache(default_folder() if cache is None else cache), backend)
    return open_folders(folders, where=where or (), store=store)
