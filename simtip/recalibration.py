"""A scene's rig as a calibration of it comes out, from points of a board and without images.

Poses are planned as `simtip boards` plans them. The true cameras, distortion and all, say where
each point of the board is seen, and normal noise stands for a finder's error. `simtip.calibrate` is
given the points that the board is said to have, no more. Its rig is therefore off as one from as
many photographs is: by the noise, by what its lens model leaves out, by a board that is bowed or
printed in another size. A finder's error on photographs has other parts besides, such as the bias
of blur on a tilted board (docs/calibration.md, Limits).
"""

from __future__ import annotations

from simtip.boards import BoardSet, plan_boards
from simtip.calibrate import Calibration, View, calibrate
from simtip.camera import Camera, StereoRig
from simtip.geometry import Array
from simtip.seeding import stream
from simtip.spec import SceneSpec
from simtip.spec.recalibration import RecalibrationSpec
from simtip.target.sighting import Sighting


def recalibrated(spec: SceneSpec, how: RecalibrationSpec) -> StereoRig:
    """Give the rig that a calibration makes of the scene's rig.

    Parameters and errors are those of `recalibrate`. `simtip.rig_file.write_rig` makes a file of it
    that a scene's `rig.measured` may name.
    """
    return recalibrate(spec, how).rig


def recalibrate(spec: SceneSpec, how: RecalibrationSpec) -> Calibration:
    """Calibrate the scene's rig, with all that the calibration says of itself.

    Parameters
    ----------
    spec
        The scene: `rig` is the true rig, `boards` the board and where it may be held. Its `seed`
        and `boards.views` do not matter.
    how
        What the calibration is made from.

    Returns
    -------
    Calibration
        For images as the scene's cameras read them out, in the calibrated left camera's frame, mm.
        Where the board does not fit into a region of interest, calibrate the scene without it:
        `rig.measured` takes rigs of whole sensors, too.

    Raises
    ------
    InputError
        Too few poses fit, or the views do not determine the rig.
    """
    boards = spec.boards.model_copy(update={"views": how.views})
    plan = plan_boards(spec.model_copy(update={"boards": boards}), seed=how.seed)
    true = spec.rig.rig()
    return calibrate(
        sightings(plan, how.corner_noise_px),
        plan.plate.target.points / (1 + how.print_scale_error),
        true.left.size,
        true.right.size,
        model=how.distortion,
        turnable=False,  # the points have their true numbers
    )


def sightings(boards: BoardSet, noise_px: float) -> list[View]:
    """Say where the true cameras see the points of every view of a board.

    Parameters
    ----------
    boards
        The views; `BoardSet.seed` is the noise's root, too, in a stream of its own for each image.
    noise_px
        Standard deviation of the normal noise in u and in v, px.

    Returns
    -------
    list of View
        Without the points that come to lie outside of the image.
    """
    rig = boards.spec.rig.rig()
    views = []
    for k, pose in enumerate(boards.poses):
        left, right = (
            _sighting(camera, pixels + noise_px * _normal(boards.seed, k, side, len(pixels)))
            for side, camera, pixels in zip(
                ("left", "right"),
                (rig.left, rig.right),
                rig.project(pose.apply(boards.plate.points)),
                strict=True,
            )
        )
        views.append(View(boards.name(k), left, right))
    return views


def _normal(seed: int, k: int, side: str, count: int) -> Array:
    return stream(seed, "recalibration", k, side).standard_normal((count, 2))


def _sighting(camera: Camera, pixels: Array) -> Sighting | None:
    ids = camera.contains(pixels).nonzero()[0]
    return Sighting(ids, pixels[ids]) if len(ids) else None
