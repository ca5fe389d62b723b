"""Which left image belongs to which right image."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from simtip.calibration_images.names import (
    ENDINGS,
    Key,
    begins_with_side,
    is_image,
    key_of,
    side_of,
    without_side,
)
from simtip.errors import InputError

NAMING = (
    "name them left_01.png, right_01.png, ..., put them into folders left and right, or give a "
    "quoted pattern for each camera"
)

_WILDCARD = re.compile(r"[*?]|\[[^\]]*\]")


@dataclass(frozen=True)
class Pair:
    """Two images of one view.

    Attributes
    ----------
    name
        What both files' names share.
    left, right
        The files.
    """

    name: str
    left: Path
    right: Path


@dataclass(frozen=True)
class Pairs:
    """The images that were found.

    Attributes
    ----------
    pairs
        In natural order: 2 before 10.
    unpaired
        Images without the other camera's.
    """

    pairs: tuple[Pair, ...]
    unpaired: tuple[Path, ...]


@dataclass(frozen=True)
class _Named:
    """A file, and the part of its name that its pair shares."""

    rest: str
    file: Path


def find_pairs(images: Sequence[str]) -> Pairs:
    """Find stereo pairs of images, by their names.

    Two images are a pair if what is left of their names is the same but for separators at its ends,
    capitals and leading zeros: ``left_01.png`` and ``Right1.JPG``. Left out are, of a file found by
    a pattern, what the pattern says before its first and after its last wildcard, and the words
    left and right.

    Parameters
    ----------
    images
        One folder that holds ``left*`` and ``right*`` images (or, if no name begins so, names with
        left and right as words), or sub-folders ``left`` and ``right``. Or a pattern or a folder
        for the left and one for the right images. Or, as a shell makes of patterns, all the files.

    Raises
    ------
    InputError
        Nothing there, images of one camera only, none that match, or two of one view.
    """
    shown = " ".join(images)
    if len(images) == 1 and Path(images[0]).is_dir():
        left, right = _in_folder(Path(images[0]))
    elif len(images) == 2:
        left, right = (_of_camera(text) for text in images)
    elif len(images) == 1:
        raise InputError(
            "is no folder", file=images[0], remedy="give one, or a pattern for each camera, quoted"
        )
    else:
        left, right = _by_side([Path(text) for text in images])
        shown = f"{images[0]} ... {images[-1]}"
    return _paired(left, right, shown)


def _in_folder(folder: Path) -> tuple[list[_Named], list[_Named]]:
    files = _images_in(folder)
    beginning = [file for file in files if begins_with_side(file.stem)]
    left, right = _by_side(beginning or files)
    if left or right:
        return left, right
    inner = {path.name.lower(): path for path in _listed(folder) if path.is_dir()}
    if "left" in inner and "right" in inner:
        return _named(_images_in(inner["left"])), _named(_images_in(inner["right"]))
    raise InputError(
        f"has no images that are named left and right, and {len(files)} others",
        file=folder,
        remedy=NAMING,
    )


def _of_camera(text: str) -> list[_Named]:
    """Give the images of a folder, a file or a pattern."""
    path = Path(text)
    if path.is_dir():
        found = _named(_images_in(path))
    elif path.is_file():
        found = _named([path])
    else:
        found = _matching(text)
    if not found:
        raise InputError(f"no images ({', '.join(ENDINGS)}) are there", file=text, remedy=NAMING)
    return found


def _matching(pattern: str) -> list[_Named]:
    path = Path(pattern)
    text = str(path)
    wildcards = list(_WILDCARD.finditer(text))
    if not wildcards:
        return []
    before, after = wildcards[0].start(), len(text) - wildcards[-1].end()
    fixed = sum(1 for part in path.parents if not _WILDCARD.search(str(part)))
    base = Path(*path.parts[:fixed]) if path.is_absolute() else Path(*path.parts[: fixed - 1])
    named = []
    for file in _globbed(base, str(path.relative_to(base)), pattern):
        if is_image(file) and file.is_file():
            rest = str(file)[before : len(str(file)) - after]
            named.append(_Named(without_side(rest.removesuffix(file.suffix)), file))
    return named


def _globbed(base: Path, pattern: str, shown: str) -> list[Path]:
    try:
        return sorted(base.glob(pattern))
    except (ValueError, NotImplementedError, OSError) as error:
        raise InputError(f"is no pattern ({error})", file=shown, remedy=NAMING) from None


def _by_side(files: Iterable[Path]) -> tuple[list[_Named], list[_Named]]:
    """Sort files by left and right in their names, or else in their folders' names."""
    left: list[_Named] = []
    right: list[_Named] = []
    for file in files:
        side = side_of(file.stem) or side_of(file.parent.name)
        if side is not None:
            (left if side == "left" else right).append(_Named(without_side(file.stem), file))
    return left, right


def _named(files: Iterable[Path]) -> list[_Named]:
    return [_Named(without_side(file.stem), file) for file in files]


def _images_in(folder: Path) -> list[Path]:
    return [path for path in _listed(folder) if is_image(path) and path.is_file()]


def _listed(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror})", file=folder, remedy="check its permissions"
        ) from None


def _paired(left: list[_Named], right: list[_Named], shown: str) -> Pairs:
    if not left and not right:
        raise InputError("no image is named left or right", file=shown, remedy=NAMING)
    for side, named, other in (("left", left, right), ("right", right, left)):
        if not named:
            raise InputError(
                f"has {len(other)} images, but none of the {side} camera", file=shown, remedy=NAMING
            )
    lefts, rights = _by_key(left), _by_key(right)
    pairs = tuple(
        Pair(lefts[key].rest or lefts[key].file.stem, lefts[key].file, rights[key].file)
        for key in sorted(lefts.keys() & rights.keys())
    )
    if not pairs:
        raise InputError(
            f"no name of the {len(left)} left images fits one of the {len(right)} right ones "
            f"({left[0].file.name}, {right[0].file.name})",
            file=shown,
            remedy=NAMING,
        )
    for pair in pairs:
        if pair.left.resolve() == pair.right.resolve():
            raise InputError("is both the left and the right image", file=pair.left, remedy=NAMING)
    alone = sorted(lefts.keys() ^ rights.keys())
    return Pairs(pairs, tuple((lefts.get(key) or rights[key]).file for key in alone))


def _by_key(named: list[_Named]) -> dict[Key, _Named]:
    found: dict[Key, _Named] = {}
    for one in named:
        key = key_of(one.rest)
        if key in found:
            raise InputError(
                f"shows the same view as {found[key].file.name}, by its name",
                file=one.file,
                remedy="rename or remove one of them",
            )
        found[key] = one
    return found
