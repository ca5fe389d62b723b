"""Which kind of folder it is, and its reader."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from simtip.boards_folder import DIGEST
from simtip.errors import InputError
from simtip.experiment.performed import HEAD as EXPERIMENT
from simtip.experiment.performed import SWEEPS
from simtip.image_sets.boards import BoardFolder
from simtip.image_sets.pairs import BoardImages, NeedleImages
from simtip.image_sets.result import MANIFEST, RESTORE, TRUTH, ResultImages
from simtip.image_sets.sweep import Store, SweepImages
from simtip.input_file import require_folder
from simtip.json_file import read_json
from simtip.sweep.head import HEAD

KINDS = "name a folder of `simtip run`, `render`, `remix`, `boards`, `sweep`, `mca` or `budget`"


@dataclass(frozen=True)
class Contents:
    """What some folders hold; only one of the two is there.

    Attributes
    ----------
    needles
        Pairs of images of needles, by folder.
    boards
        Pairs of images of calibration boards, by folder.
    """

    needles: tuple[NeedleImages, ...] = ()
    boards: tuple[BoardImages, ...] = ()

    def __len__(self) -> int:
        """Give the number of pairs."""
        return sum(len(one) for one in self.needles) + sum(len(one) for one in self.boards)


def open_folders(
    folders: Sequence[Path], *, where: Sequence[str] = (), store: Store | None = None
) -> Contents:
    """Open some folders, and check what is in them.

    Parameters
    ----------
    folders
        At least one.
    where
        Conditions that the trials of sweeps have to meet.
    store
        Where the images of sweeps are looked for.

    Raises
    ------
    InputError
        One is no folder of simtip's, or not as it was written; there are conditions and no sweeps;
        or needles and boards are mixed.
    """
    needles: list[NeedleImages] = []
    boards: list[BoardImages] = []
    for folder in folders:
        sweeps = _sweeps_in(folder)
        if sweeps:
            needles += [SweepImages(one, where, store or Store()) for one in sweeps]
            continue
        if where:
            raise InputError(
                f"asks for trials, and {folder} is no folder of a sweep",
                field="--where",
                remedy="leave it out",
            )
        if _is_of_boards(folder):
            boards.append(BoardFolder(folder))
        else:
            needles.append(ResultImages(folder))
    if needles and boards:
        raise InputError(
            f"holds calibration boards, and {needles[0].source} needles",
            file=boards[0].source,
            remedy="give them one after the other",
        )
    return Contents(tuple(needles), tuple(boards))


def _sweeps_in(folder: Path) -> list[Path]:
    """Give the folders of sweeps: this one, or those that an experiment made in it."""
    require_folder(folder, KINDS)
    if (folder / HEAD).exists():
        return [folder]
    if not (folder / EXPERIMENT).exists():
        return []
    found = sorted(head.parent for head in (folder / SWEEPS).glob(f"*/{HEAD}"))
    if not found:
        raise InputError("holds no sweep yet", file=folder, remedy="let its command go on")
    return found


def _is_of_boards(folder: Path) -> bool:
    """Say whether a folder is of boards, or else of one pair."""
    if (folder / MANIFEST).exists():
        return False
    truth = folder / TRUTH
    if truth.exists() and DIGEST in read_json(truth, RESTORE):
        return True
    if not truth.exists():
        raise InputError(f"holds no {MANIFEST}, {TRUTH} or {HEAD}", file=folder, remedy=KINDS)
    raise InputError(
        f"is cut short: it holds {TRUTH} and no {MANIFEST}", file=folder, remedy=RESTORE
    )
