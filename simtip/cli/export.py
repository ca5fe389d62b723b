"""`simtip export`: images and truth for other programs."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from simtip.cli.experiment import CacheOption
from simtip.cli.folders import FoldersArgument, WhereOption, opened
from simtip.cli.options import BackendOption, JsonOption, named
from simtip.cli.output import print_json, say, say_where

if TYPE_CHECKING:
    from simtip.image_sets import Contents


def export(
    folders: FoldersArgument,
    form: Annotated[
        Literal["bop", "coco", "opencv", "csv"],
        typer.Option(
            "--format",
            help="bop: scenes with depth, masks, poses and models, of needles. coco: keypoints, "
            "masks and boxes. opencv: rigs, image lists and true points for cv2.FileStorage. csv: "
            "tables. All but bop hold boards, too.",
        ),
    ],
    out: Annotated[
        Path,
        typer.Option("-o", "--out", parser=named, metavar="DIR", help="New or empty folder."),
    ],
    where: WhereOption = None,
    undistort: Annotated[
        bool,
        typer.Option(
            "--undistort", help="For bop: resample images of lenses with distortion, linearly."
        ),
    ] = False,
    cache: CacheOption = None,
    backend: BackendOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write images and their truth in formats that other programs read.

    DIR is a folder of run, render, remix, boards, sweep, mca or budget, or several. Sweeps' images
    come from the cache, or are rendered again if this simtip would make the same.
    """
    from simtip.console import progress_bar
    from simtip.export import Settings, write_export
    from simtip.export.formats import check_format
    from simtip.output_folder import OutputFolder, result_folder

    OutputFolder(out).check()
    contents = opened(folders, where, cache, backend)
    settings = Settings(backend, undistort)
    check_format(form, contents, settings)
    count = 0
    with progress_bar("exporting") as progress, result_folder(out) as folder:

        def done() -> None:
            nonlocal count
            count += 1
            progress(count / len(contents))

        write_export(folder, contents, form, settings, done=done)
    left_out = _left_out(contents)
    if as_json:
        print_json({"out": str(out), "format": form, "pairs": count, "left_out": left_out})
        return
    if left_out:
        many = ", ".join(f"{number} {status}" for status, number in left_out.items())
        say(f"trials without images: {many}")
    say_where(out, f"{count} pair{'' if count == 1 else 's'} of images as {form}")


def _left_out(contents: Contents) -> dict[str, int]:
    """Count trials that have no images, by status."""
    counts: Counter[str] = Counter()
    for one in contents.needles:
        counts.update(one.without_images)
    return dict(sorted(counts.items()))
