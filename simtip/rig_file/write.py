"""Rigs to files of any format."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, TypeAlias, get_args

from simtip.camera import StereoRig
from simtip.errors import InputError
from simtip.output_folder import write_atomically
from simtip.rig_file.kalibr import kalibr_text
from simtip.rig_file.opencv_xml import opencv_xml_text
from simtip.rig_file.opencv_yaml import opencv_yaml_text
from simtip.rig_file.own_json import json_text
from simtip.rig_file.ros import ros_texts
from simtip.rig_file.ros_pair import is_folder, pair_of

Format: TypeAlias = Literal["opencv", "opencv-xml", "json", "ros", "kalibr"]
FORMATS: tuple[Format, ...] = get_args(Format)

_YAML = (".yaml", ".yml")
_SAID: dict[str, Format] = {
    ".yaml": "opencv",
    ".yml": "opencv",
    ".xml": "opencv-xml",
    ".json": "json",
}
"""Which format an ending says."""
_ENDINGS: dict[Format, tuple[str, ...]] = {
    "opencv": _YAML,
    "opencv-xml": (".xml",),
    "json": (".json",),
    "ros": _YAML,
    "kalibr": _YAML,
}


def write_rig(
    path: str | Path,
    rig: StereoRig,
    form: Format | None = None,
) -> None:
    """Write a rig as files that `read_rig` reads back, and the programs whose formats they are.

    Numbers are written so that they read back to the same floats. Each file appears whole or not
    at all. Conventions and units stand in the file.

    Parameters
    ----------
    path
        The file; an existing one is replaced. For ``ros`` a folder, which is made and gets
        ``left.yaml`` and ``right.yaml``, or one file of the pair, named left or right.
    rig
        What to write.
    form
        By default what the ending says: ``.yaml`` and ``.yml`` are ``opencv``, ``.xml`` is
        ``opencv-xml``, ``.json`` is ``json``.

    Raises
    ------
    InputError
        A file cannot be written, its name does not suit the format, or the format cannot hold the
        rig: ROS and Kalibr have fewer coefficients of distortion.
    """
    chosen = _chosen(path, form)
    files = rig_files(path, chosen)
    texts = ros_texts(rig, path) if chosen == "ros" else (_text(rig, chosen, path),)
    if files[0].parent == Path(path):
        _make_folder(files[0].parent)
    for file, text in zip(files, texts, strict=True):
        write_atomically(file, text.encode())


def rig_files(
    path: str | Path,
    form: Format | None = None,
) -> tuple[Path, ...]:
    """Give the files that `write_rig` writes: one, or for ROS the left and the right one.

    Raises
    ------
    InputError
        The name does not suit the format.
    """
    chosen = _chosen(path, form)
    file = Path(path)
    if chosen != "ros":
        return (file,)
    if not file.suffix or is_folder(file):
        return file / "left.yaml", file / "right.yaml"
    return pair_of(file)


def rig_text(
    rig: StereoRig,
    form: Format = "opencv",
) -> str:
    """Give the text of a format that is one file.

    Raises
    ------
    InputError
        The format cannot hold the rig, or is two files.
    """
    return _text(rig, form, None)


def _text(rig: StereoRig, kind: Format, path: str | Path | None) -> str:
    if kind == "ros":
        raise InputError("is a pair of files", field=kind, remedy="name a folder to write to")
    if kind == "kalibr":
        return kalibr_text(rig, path)
    writers = {"opencv": opencv_yaml_text, "opencv-xml": opencv_xml_text, "json": json_text}
    return writers[kind](rig)


def _chosen(path: str | Path, kind: Format | None) -> Format:
    """Give the format, and refuse a name that would deceive other programs."""
    ending = Path(path).suffix.lower()
    if kind is None:
        if ending not in _SAID:
            raise InputError(
                f"ends in {ending!r}, which says no format",
                file=path,
                remedy="end it in .yaml, .xml or .json, or name the format",
            )
        return _SAID[ending]
    if kind not in _ENDINGS:
        raise InputError(
            f"{kind!r} is no format", field="format", remedy=f"choose {', '.join(FORMATS)}"
        )
    folder = kind == "ros" and (not ending or is_folder(path))
    if ending not in _ENDINGS[kind] and not folder:
        raise InputError(
            f"ends in {ending!r}, and {kind} files do not",
            file=path,
            remedy=f"end it in {' or '.join(_ENDINGS[kind])}",
        )
    return kind


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(exist_ok=True)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"cannot be made ({reason})", file=folder, remedy="name another folder"
        ) from error
