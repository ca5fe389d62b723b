"""The formats, and which of them holds what."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias, get_args

from simtip.errors import InputError
from simtip.export import bop, coco, csv_table, opencv
from simtip.image_sets import Contents
from simtip.render import choose

Format: TypeAlias = Literal["bop", "coco", "opencv", "csv"]
FORMATS: tuple[Format, ...] = get_args(Format)


@dataclass(frozen=True)
class Settings:
    """How an export is made.

    Attributes
    ----------
    backend
        What traces masks and depth; None is the best there is.
    undistort
        Whether images are resampled for a format that knows no distortion.
    """

    backend: str | None = None
    undistort: bool = False


def check_format(form: Format, contents: Contents, settings: Settings) -> None:
    """Refuse what does not go together.

    Raises
    ------
    InputError
        The format does not hold what there is, or is not asked to.
    """
    if contents.boards and form == "bop":
        raise InputError(
            "holds needles, and these are images of calibration boards",
            field="--format bop",
            remedy="take coco, opencv or csv",
        )
    if settings.undistort and form != "bop":
        raise InputError(
            f"is for bop; {form} holds images as they were taken",
            field="--undistort",
            remedy="leave it out",
        )


def write_export(
    folder: Path,
    contents: Contents,
    form: Format,
    settings: Settings,
    *,
    done: Callable[[], None] = lambda: None,
) -> None:
    """Write pairs of images and their truth into an empty folder.

    Parameters
    ----------
    folder
        The folder.
    contents
        Where the pairs are.
    form
        In which format.
    settings
        How.
    done
        Called after each pair.

    Raises
    ------
    InputError
        The format does not hold what there is, or a pair cannot be read.
    """
    check_format(form, contents, settings)
    if contents.boards:
        boards = {
            "coco": coco.write_boards,
            "opencv": opencv.write_boards,
            "csv": csv_table.write_boards,
        }
        boards[form](folder, contents.boards, done=done)
        return
    if form == "opencv":
        opencv.write_needles(folder, contents.needles, done=done)
        return
    chosen = choose(settings.backend)
    if form == "bop":
        bop.write_bop(
            folder, contents.needles, backend=chosen, undistort=settings.undistort, done=done
        )
        return
    needles = {"coco": coco.write_needles, "csv": csv_table.write_needles}
    needles[form](folder, contents.needles, backend=chosen, done=done)
