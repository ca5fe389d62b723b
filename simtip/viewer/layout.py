"""Which views there are, and what each shows at first."""

from __future__ import annotations

import numpy as np
import rerun.blueprint as rrb

from simtip.geometry import Array
from simtip.viewer.paths import ABOUT, BACKGROUND, ERROR, LAMPS, WORLD, image_of

FROM = np.array([1.1, -0.7, -0.6])
"""Whence one looks at first, in distances of the subject from the left camera: from the right."""


def layout(subject_mm: Array, *, measured: bool) -> rrb.Blueprint:
    """Give space on the left, both images and what is said of them on the right.

    Lamps and background, which are large and far away, are switched off at first.

    Parameters
    ----------
    subject_mm
        (3,) what is in the middle of space, world.
    measured
        Whether there may be errors to plot.
    """
    left, right = (
        rrb.Spatial2DView(name=side, origin=image_of(side), contents=f"{image_of(side)}/**")
        for side in ("left", "right")
    )
    words = rrb.TextDocumentView(name="about", origin=ABOUT)
    middle = subject_mm / 2
    space = rrb.Spatial3DView(
        name="space",
        origin=WORLD,
        contents=[f"+ {WORLD}/**", f"- {LAMPS}/**", f"- {BACKGROUND}/**"],
        eye_controls=rrb.EyeControls3D(
            position=middle + FROM * np.linalg.norm(subject_mm),
            look_target=middle,
            eye_up=(0, -1, 0),
        ),
    )
    told = (words, rrb.TimeSeriesView(name="error", origin=ERROR)) if measured else (words,)
    images = rrb.Horizontal(left, right)
    right_half = rrb.Vertical(images, rrb.Horizontal(*told), row_shares=[3, 1])
    return rrb.Blueprint(rrb.Horizontal(space, right_half), collapse_panels=True)
