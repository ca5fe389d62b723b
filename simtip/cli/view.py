"""`simtip view`: rig, needle, rays and images in space."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from simtip.cli.experiment import CacheOption
from simtip.cli.folders import FoldersArgument, WhereOption, opened
from simtip.cli.options import BackendOption, named
from simtip.cli.output import say_where


def view(
    folders: FoldersArgument,
    save: Annotated[
        Path | None,
        typer.Option(
            "--save", parser=named, metavar="FILE", help="New .rrd file, instead of a window."
        ),
    ] = None,
    where: WhereOption = None,
    cache: CacheOption = None,
    backend: BackendOption = None,
) -> None:
    """Look at rig, needle, rays and images in Rerun, which comes with the extra `viewer`.

    DIR is as for `simtip export`. The timeline counts trials.
    """
    from simtip.console import progress_bar
    from simtip.viewer import Destination, show

    destination = Destination(save)
    destination.check()
    contents = opened(folders, where, cache, backend)
    count = 0
    with progress_bar("recording") as progress:

        def done() -> None:
            nonlocal count
            count += 1
            progress(count / len(contents))

        show(contents, destination, done=done)
    say_where(save, f"{count} pair{'' if count == 1 else 's'} of images; open it with `rerun`")
