"""What is wrong with the views themselves, before or after they are calibrated from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simtip.calibrate.bundle import Fit
from simtip.calibrate.corners import View
from simtip.calibrate.mono import UNDETERMINED, undetermined
from simtip.calibrate.planar import homography_of, normal_of
from simtip.calibrate.problem import Problem, linearised
from simtip.calibrate.square_root import shared_covariance
from simtip.errors import InputError
from simtip.geometry import Array, unit
from simtip.target.sighting import Sighting

MIN_VIEWS = 3
"""Zhang's method takes three positions of the board."""

PARALLEL_DEG = 1.0
"""Boards whose normals stay within this of their mean count as parallel."""

REFERENCE_PX = 0.1
"""Corner noise that the determination of a camera is judged at."""

MOST_FOCAL_SHARE, MOST_CENTRE_SHARE = 0.03, 0.05
"""Largest standard deviation, at that noise, of a focal length, relative, and of the principal
point, relative to the image's width. Twenty tilted views are a hundred times better."""


def check_input(
    views: Sequence[View], points_mm: Array, sizes: tuple[tuple[int, int], tuple[int, int]]
) -> None:
    """Refuse what cannot be views of this target by these cameras.

    Raises
    ------
    InputError
        Naming the view, or the target.
    """
    if points_mm.ndim != 2 or points_mm.shape[1] != 3 or not np.isfinite(points_mm).all():
        raise InputError(
            "the target's points are not (n, 3) finite numbers",
            field="target",
            remedy="give x, y, z of each point in mm",
        )
    if np.ptp(points_mm[:, 2]) > 0:
        raise InputError(
            "the target is not flat", field="target", remedy="give points that all have the same z"
        )
    names = [view.name for view in views]
    for name in names:
        if names.count(name) > 1:
            raise InputError("two views have this name", field=name, remedy="name each once")
    for view in views:
        for camera, sighting, size in zip(
            ("left", "right"), (view.left, view.right), sizes, strict=True
        ):
            if sighting is not None:
                _check_sighting(sighting, len(points_mm), size, f"{view.name} {camera}")


def _check_sighting(sighting: Sighting, count: int, size: tuple[int, int], field: str) -> None:
    ids, pixels = sighting.ids, sighting.pixels
    if pixels.shape != (len(ids), 2) or not np.isfinite(pixels).all():
        raise InputError(
            "the points seen are not finite pairs u, v, one for each number", field=field
        )
    if len(ids) and (ids.min() < 0 or ids.max() >= count or (np.diff(ids) <= 0).any()):
        raise InputError(
            f"the points' numbers do not ascend within 0 to {count - 1}",
            field=field,
            remedy="give the target that was photographed",
        )
    outside = (pixels < -0.5).any(axis=1) | (pixels >= np.array(size) - 0.5).any(axis=1)
    if outside.any():
        u, v = pixels[outside][0]
        raise InputError(
            f"a point at ({u:.1f}, {v:.1f}) lies outside the image of {size[0]} x {size[1]} px",
            field=field,
            remedy="use images of one size",
        )


def require_views(count: int, found_by: str, rejected: Sequence[str] = ()) -> None:
    """Refuse fewer than three views.

    Parameters
    ----------
    count
        How many are usable.
    found_by
        By what, for the message: ``by both cameras``.
    rejected
        Reasons why others are not, of which the first is told.

    Raises
    ------
    InputError
        There are too few.
    """
    if count < MIN_VIEWS:
        why = f" ({rejected[0]})" if rejected else ""
        raise InputError(
            f"the target is usable in {count} views seen {found_by}, {MIN_VIEWS} are needed{why}",
            field="views",
            remedy="take more; twenty are a good number",
        )


def require_tilts(
    sightings: Sequence[Sighting | None], points_mm: Array, size: tuple[int, int], camera: str
) -> None:
    """Refuse boards that are all parallel: they leave the camera open (Zhang 2000, section 4).

    Raises
    ------
    InputError
        Every board is parallel to the others.
    """
    found = [homography_of(s, points_mm) for s in sightings if s is not None]
    normals = np.array([normal_of(f, size) for f in found if f is not None])
    normals = normals * np.sign(normals[:, 2:])
    mean = unit(normals.mean(axis=0))
    sines = np.linalg.norm(np.cross(normals, mean), axis=1)
    most = float(np.degrees(np.arcsin(np.minimum(sines, 1.0)).max()))
    if most < PARALLEL_DEG:
        raise InputError(
            f"all boards seen by the {camera} camera are parallel (within about {most:.2g} "
            "degrees), which leaves its focal length open",
            field="views",
            remedy=UNDETERMINED,
        )


def require_determined(problem: Problem, fit: Fit, size: tuple[int, int], camera: str) -> None:
    """Refuse views that leave the focal lengths or the principal point of one camera open.

    Parameters
    ----------
    problem, fit
        Of that camera alone.
    size
        (width, height), px.
    camera
        ``left`` or ``right``.

    Raises
    ------
    InputError
        The views do not determine the camera.
    """
    try:
        covariance = shared_covariance(problem, linearised(problem, fit.at))
    except np.linalg.LinAlgError:
        raise undetermined(camera, "the least-squares problem is singular") from None
    std = REFERENCE_PX * np.sqrt(np.diagonal(covariance)[:4])
    shares = std / np.array([fit.at.left[0], fit.at.left[1], size[0], size[0]])
    if shares[:2].max() > MOST_FOCAL_SHARE:
        raise undetermined(
            camera,
            f"corner noise of {REFERENCE_PX} px would leave its focal length uncertain by "
            f"{shares[:2].max():.2g} of itself",
        )
    if shares[2:].max() > MOST_CENTRE_SHARE:
        raise undetermined(
            camera,
            f"corner noise of {REFERENCE_PX} px would leave its principal point uncertain by "
            f"{std[2:].max():.3g} px",
        )


def require_order(T_lr: Array) -> None:
    """Refuse a right camera at the left of the left one.

    Parameters
    ----------
    T_lr
        (3,) mm, the right camera in the left camera's frame.

    Raises
    ------
    InputError
        Its x is negative.
    """
    if T_lr[0] < 0:
        raise InputError(
            f"the right camera comes out {-T_lr[0]:.1f} mm to the left of the left one: the images "
            "are swapped",
            field="views",
            remedy="exchange left and right, or unmirror them if both are mirrored",
        )
