"""Depth and masks of pairs, traced once where pairs in a row show the same thing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from simtip.camera import StereoRig
from simtip.light_inputs import light_digest
from simtip.render import Backend, trace_surfaces
from simtip.spec import SceneSpec

if TYPE_CHECKING:
    from simtip.render.surfaces import Surfaces


class Tracer:
    """Traces scenes, and remembers the last one: powers, exposures and noise change nothing of it.

    Parameters
    ----------
    backend
        What traces.
    beyond
        As for `simtip.render.trace_surfaces`.
    """

    def __init__(self, backend: Backend, beyond: int = 0) -> None:
        self._backend, self._beyond = backend, beyond
        self._key = ""
        self._last: tuple[Surfaces, Surfaces] | None = None

    def trace(
        self, spec: SceneSpec, rig: StereoRig, points_mm: ArrayLike = ()
    ) -> tuple[Surfaces, Surfaces]:
        """Give what both cameras of a rig see; rig and points have to follow from the scene."""
        key = light_digest(spec)
        if self._last is None or key != self._key:
            self._last = trace_surfaces(
                spec, backend=self._backend, rig=rig, points_mm=points_mm, beyond=self._beyond
            )
            self._key = key
        return self._last
