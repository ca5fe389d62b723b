"""Which views there are, and what each shows at first."""

from __future__ import annotations

import rerun.blueprint as rrb

from simtip.viewer.paths import ABOUT, ERROR, LAMPS, WORLD, image_of


def layout(*, measured: bool) -> rrb.Blueprint:
    """Give space on the left, both images and what is said of them on the right.

    Lamps, which are far away, are switched off at first.
    """
    left, right = (
        rrb.Spatial2DView(name=side, origin=image_of(side), contents=f"{image_of(side)}/**")
        for side in ("left", "right")
    )
    words = rrb.TextDocumentView(name="about", origin=ABOUT)
    space = rrb.Spatial3DView(
        name="rig and needle", origin=WORLD, contents=[f"+ {WORLD}/**", f"- {LAMPS}/**"]
    )
    told = (words, rrb.TimeSeriesView(name="error", origin=ERROR)) if measured else (words,)
    images = rrb.Horizontal(left, right)
    return rrb.Blueprint(rrb.Horizontal(space, rrb.Vertical(images, rrb.Horizontal(*told))))
