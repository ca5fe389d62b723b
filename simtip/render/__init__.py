"""Rendering: a scene to radiance per lamp. The only part of simtip that loads Mitsuba.

Importing this package loads neither Mitsuba nor Dr.Jit; the first render does.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from simtip.camera import Camera
from simtip.errors import InputError
from simtip.geometry import Pose
from simtip.lens import ThinLens
from simtip.plate import Plate
from simtip.render.backend import Backend, activated, choose
from simtip.render.view import Floats, Progress, Tolerance, View
from simtip.spec import SceneSpec

if TYPE_CHECKING:
    from simtip.camera import StereoRig
    from simtip.render.moved import MovableNeedle
    from simtip.render.surfaces import Surfaces

__all__ = [
    "Backend",
    "Progress",
    "Tolerance",
    "View",
    "choose",
    "movable_needle",
    "render_board",
    "render_discs",
    "render_pair",
    "require_boards",
    "trace_surfaces",
]


def render_pair(
    spec: SceneSpec,
    *,
    backend: Backend | None = None,
    seed: int | None = None,
    tolerance: Tolerance | None = None,
    progress: Progress | None = None,
) -> tuple[View, View]:
    """Render the left and the right view of a scene.

    Parameters
    ----------
    spec
        The scene.
    backend
        What renders; by default what `choose` finds.
    seed
        Of the Monte-Carlo samples; by default the scene's own. Each camera has its own stream, and
        equal seeds give equal bits on one back end.
    tolerance
        How noisy which pixel may be, see `simtip.noise_budget`; without one, or with
        ``render.noise: null``, every pixel that needs sampling takes `render.samples`.
    progress
        Called with the fraction done.

    Returns
    -------
    tuple of View
        Left, right.
    """
    backend = backend or choose()
    with activated(backend):
        # Imported only now: these modules read the active variant's types.
        if backend.name == "scalar":
            from simtip.render.serial import render_views
        else:
            from simtip.render.pair import render_views
        return render_views(spec, backend, spec.seed if seed is None else seed, tolerance, progress)


@contextmanager
def movable_needle(spec: SceneSpec, *, backend: Backend, seed: int) -> Iterator[MovableNeedle]:
    """Render a scene, and keep it loaded so that its needle can be moved and looked at again.

    Parameters
    ----------
    spec
        The scene; `render.samples` are spent on every sampled pixel of the views, whatever
        `render.noise` says.
    backend
        A vectorised one. It stays active within the block.
    seed
        Of the Monte-Carlo samples.

    Raises
    ------
    InputError
        The back end is scalar.
    """
    if backend.name == "scalar":
        raise InputError(
            "the scalar back end cannot move a needle that is loaded",
            field="--backend",
            remedy="install an LLVM library, see `simtip doctor`",
        )
    with activated(backend):
        from simtip.render.moved import set_movable

        yield set_movable(spec, backend, seed)


def render_board(
    spec: SceneSpec,
    plate: Plate,
    T_wt: Pose,
    *,
    backend: Backend | None = None,
    seed: int | None = None,
    tolerance: Tolerance | None = None,
    progress: Progress | None = None,
) -> tuple[View, View]:
    """Render the left and the right view of a scene with a calibration board for the needle.

    Parameters
    ----------
    spec
        The scene; `boards.plate` says what the board looks like.
    plate
        Its geometry.
    T_wt
        From its frame to the world, mm.
    backend, seed, tolerance, progress
        As for `render_pair`.

    Returns
    -------
    tuple of View
        Left, right; their `coverage` is the board's.

    Raises
    ------
    InputError
        The back end is scalar, which renders needles only.
    """
    backend = backend or choose()
    require_boards(backend)
    with activated(backend):
        from simtip.render.board_subject import BoardSubject
        from simtip.render.pair import render_views

        subject = BoardSubject(plate, T_wt, spec.boards.plate)
        chosen = spec.seed if seed is None else seed
        return render_views(spec, backend, chosen, tolerance, progress, subject)


def require_boards(backend: Backend) -> None:
    """Refuse a back end that renders no calibration boards.

    Raises
    ------
    InputError
        It is the scalar one.
    """
    if backend.name == "scalar":
        raise InputError(
            "the scalar back end renders no calibration boards",
            field="--backend",
            remedy="install an LLVM library, see `simtip doctor`",
        )


def trace_surfaces(
    spec: SceneSpec,
    *,
    backend: Backend,
    rig: StereoRig | None = None,
    points_mm: ArrayLike = (),
    beyond: int = 0,
) -> tuple[Surfaces, Surfaces]:
    """Say what lies behind every pixel's centre, left and right, without working out any light.

    Its `depth_mm` is that of `render_pair`.

    Parameters
    ----------
    spec
        The scene; its seed places the clutter.
    backend
        A vectorised one.
    rig
        Cameras at the places of the scene's; by default these.
    points_mm
        (n, 3) world, mm, of which is to be known whether something stands before them.
    beyond
        How many times its own width and height the silhouette goes on beyond the image, each way.

    Raises
    ------
    InputError
        The back end is scalar.
    """
    if backend.name == "scalar":
        raise InputError(
            "the scalar back end traces no masks",
            field="--backend",
            remedy="install an LLVM library, see `simtip doctor`",
        )
    with activated(backend):
        from simtip.render.surfaces import trace

        return trace(spec, rig or spec.rig.rig(), points_mm, beyond)


def render_discs(
    camera: Camera,
    T_wc: Pose,
    points_mm: ArrayLike,
    radius_mm: float,
    *,
    lens: ThinLens | None = None,
    samples: int = 256,
    seed: int = 0,
    backend: Backend | None = None,
) -> Floats:
    """Render bright discs, parallel to the image plane, on black.

    A disc at constant depth is projected to an ellipse whose centroid is the projection of the
    disc's centre, exactly, as long as there is no lens distortion; so the centroids of the blobs
    tell where the renderer puts points.

    Parameters
    ----------
    camera
        With distortion, the centroid moves by the distortion's curvature over the disc.
    T_wc
        Its pose in the world.
    points_mm
        (n, 3) disc centres in the world, mm, in front of the camera.
    radius_mm
        Of the discs.
    lens
        None for a pinhole.
    samples
        Per pixel.
    seed, backend
        As for `render_pair`.

    Returns
    -------
    ndarray
        (H, W) float32, the part of each pixel that is bright.
    """
    backend = backend or choose()
    with activated(backend):
        from simtip.render.markers import render

        return render(
            camera,
            T_wc,
            points_mm,
            radius_mm,
            samples,
            seed,
            lens=lens,
            scalar=backend.name == "scalar",
        )
