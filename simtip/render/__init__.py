"""Rendering: a scene to radiance per lamp. The only part of simtip that loads Mitsuba."""

from __future__ import annotations


from simtip.render.backend import Backend, activated, choose
from simtip.render.view import Progress, View
from simtip.spec import SceneSpec

__all__ = ["Backend", "Progress", "View", "choose", "render_pair"]


def render_pair(
    spec: SceneSpec,
    *,
    backend: Backend | None = None,
    seed: int | None = None,
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
        return render_views(spec, backend, spec.seed if seed is None else seed, progress)
