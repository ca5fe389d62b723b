"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from simtip.seeding import SEED_LIMIT


def named(text: str) -> Path:
    """Read the name of a file or folder: an empty one would be the working folder's."""
    if not text:
        raise typer.BadParameter("is empty")
    return Path(text)


SceneArgument = Annotated[
    Path, typer.Argument(parser=named, metavar="SCENE", help="Scene file (YAML).")
]
OutOption = Annotated[
    Path | None,
    typer.Option(
        "-o", "--out", parser=named, metavar="DIR", help="New or empty folder for results."
    ),
]
SeedOption = Annotated[
    int | None,
    typer.Option(
        "--seed", min=0, max=SEED_LIMIT - 1, help="Root seed, instead of the scene's own."
    ),
]
BackendOption = Annotated[
    str | None,
    typer.Option("--backend", metavar="NAME", help="auto (by default), cuda, llvm or scalar."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")]
