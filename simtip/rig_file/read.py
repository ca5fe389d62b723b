"""Rig files of any format to rigs: what a file holds says what it is, not how it is named."""

from __future__ import annotations

from pathlib import Path

from simtip.camera import StereoRig
from simtip.errors import InputError
from simtip.input_file import read_bytes
from simtip.rig_file.json_document import parse_json
from simtip.rig_file.kalibr import is_kalibr, rig_from_kalibr
from simtip.rig_file.opencv import REWRITE, Size, rig_from_nodes
from simtip.rig_file.opencv_xml import parse_opencv_xml
from simtip.rig_file.own_json import is_own, rig_from_json
from simtip.rig_file.ros import is_ros, rig_from_ros
from simtip.rig_file.ros_pair import NAMING, is_folder, pair_in, pair_of
from simtip.yaml_file import Document, parse_yaml, shown

MAX_BYTES = 1024 * 1024
"""Largest rig file read: room for the views of a calibration beside the matrices."""


def read_rig(
    path: str | Path, size: Size | None = None, right_size: Size | None = None
) -> StereoRig:
    """Read a stereo rig, in whichever of five formats it is.

    - **OpenCV FileStorage**, YAML, XML or JSON. Nodes (other names in brackets), each a matrix:
      ``M1`` (``K1``, ``cameraMatrix1``), ``M2`` likewise: (3, 3) intrinsics, px, no skew.
      ``D1`` (``distCoeffs1``), ``D2`` likewise: 0, 4, 5, 8, 12 or 14 coefficients of OpenCV's
      standard model; not those of ``cv2.fisheye``. ``R``: (3, 3), or (3,) Rodrigues vector;
      ``T``: 3 values, mm (so the calibration board's squares were given in mm):
      ``p_right = R p_left + T``. Optional: ``image_width`` and ``image_height``, or ``image_size``
      (``imageSize``) ``[width, height]`` for both cameras, or ``image_size1`` and ``image_size2``.
      Other nodes (``E``, ``F``, ``R1``, ``P1``, ``Q``, ...) are ignored.
    - **simtip's JSON**, see docs/rig_files.md.
    - **ROS camera_info**, a pair of YAML files, metres: either of them, the other one being beside
      it under the same name but for left and right, or the folder that holds one pair.
    - **Kalibr camchain** YAML, metres: cam0 is the left camera, cam1 the right one.

    Parameters
    ----------
    path
        The file, or for ROS the folder.
    size
        (width, height) of the left images, px, for an OpenCV file that does not say.
    right_size
        The same of the right images; as the left by default.

    Returns
    -------
    StereoRig
        ``T_lr`` maps right-camera to left-camera coordinates, mm.

    Raises
    ------
    InputError
        Whatever is wrong, naming the file, the field and the remedy.
    """
    if is_folder(path):
        return _read_pair(*pair_in(path))
    document = _load(path)
    if is_ros(document):
        return _read_pair(*pair_of(path))
    if is_kalibr(document):
        return rig_from_kalibr(document)
    if is_own(document):
        return rig_from_json(document)
    return rig_from_nodes(document, size, right_size or size)


def _read_pair(left: Path, right: Path) -> StereoRig:
    for file, other in ((left, right), (right, left)):
        try:
            file.stat()
        except FileNotFoundError:
            raise InputError(
                f"{other.name} is there without it", file=file, remedy=NAMING
            ) from None
        except OSError:
            continue  # which reading it explains
    return rig_from_ros(_load(left), _load(right))


def _load(path: str | Path) -> Document:
    """Read a file as plain data, by how it begins."""
    data = read_bytes(path, MAX_BYTES)
    start = data.removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
    if start == b"<":
        document = parse_opencv_xml(data, path)
    elif start == b"{":
        document = parse_json(data, path)
    else:
        document = parse_yaml(data, path, opencv=True)
    if not isinstance(document.value, dict):
        raise document.error(f"a rig has named nodes, not {shown(document.value)}", remedy=REWRITE)
    return document
