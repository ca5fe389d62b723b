"""The views that are still in, and what became of the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from simtip.calibrate.calibration import Rejected, RejectedCorner
from simtip.calibrate.checks import require_views
from simtip.calibrate.corners import Corners, View, corners_of
from simtip.calibrate.lens_model import LensModel
from simtip.calibrate.planar import fault_of
from simtip.calibrate.problem import Problem
from simtip.errors import InputError
from simtip.geometry import Array
from simtip.target.sighting import Sighting


@dataclass
class Selection:
    """A calibration's material while it is being sorted.

    Attributes
    ----------
    views
        Those still in.
    points_mm
        (n, 3) the target's points.
    rejected, corners, turned, warnings
        As in `simtip.calibrate.calibration.Calibration`.
    """

    views: list[View]
    points_mm: Array
    rejected: list[Rejected] = field(default_factory=list)
    corners: list[RejectedCorner] = field(default_factory=list)
    turned: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def reject(self, name: str, reason: str) -> None:
        """Take a view out."""
        self.rejected.append(Rejected(name, reason))
        self.views = [view for view in self.views if view.name != name]

    def turn_right(self, name: str, right: Sighting) -> None:
        """Replace what the right camera saw in a view by the same, numbered anew."""
        self.turned.append(name)
        self.views = [replace(v, right=right) if v.name == name else v for v in self.views]

    @property
    def pairs(self) -> list[str]:
        """Names of the views that both cameras saw."""
        return [v.name for v in self.views if v.left is not None and v.right is not None]

    def require_pairs(self, alike: str = "by both cameras") -> None:
        """Refuse to go on with too few of them; `alike` says how they have to be seen.

        Raises
        ------
        InputError
            There are fewer than three.
        """
        require_views(len(self.pairs), alike, [f"{r.view}: {r.reason}" for r in self.rejected])

    def seen_by(self, camera: str) -> tuple[list[str], list[Sighting]]:
        """Give the views that a camera, ``left`` or ``right``, saw: names and sightings."""
        seen = [(v.name, v.left if camera == "left" else v.right) for v in self.views]
        names = [name for name, sighting in seen if sighting is not None]
        return names, [sighting for _, sighting in seen if sighting is not None]

    def table(self, camera: str) -> tuple[Corners, int]:
        """Give one camera's corners, its own views numbered from 0, and how many these are."""
        _, sightings = self.seen_by(camera)
        return corners_of(sightings, self.points_mm), len(sightings)

    def problem(self, model: LensModel) -> Problem:
        """Give the joint problem of the views still in."""
        return Problem(
            corners_of([v.left for v in self.views], self.points_mm),
            corners_of([v.right for v in self.views], self.points_mm),
            len(self.views),
            model,
        )


def screened(views: Sequence[View], points_mm: Array) -> Selection:
    """Take out what cannot be used whatever the others are.

    Raises
    ------
    InputError
        The target is mirrored throughout, or too few views are left.
    """
    selection = Selection(list(views), points_mm)
    for view in views:
        reason = _fault(view, points_mm)
        if reason:
            selection.reject(view.name, reason)
    mirrored = [r for r in selection.rejected if r.reason.endswith("mirrored")]
    if mirrored and len(mirrored) >= len(selection.views):
        raise InputError(
            f"{len(mirrored)} views show the target mirrored, the first is {mirrored[0].view}",
            field="views",
            remedy="give the images as the cameras took them, not flipped",
        )
    selection.require_pairs()
    return selection


def _fault(view: View, points_mm: Array) -> str:
    if view.left is None and view.right is None:
        return "the target was found in neither image"
    for camera, sighting in (("left", view.left), ("right", view.right)):
        fault = "" if sighting is None else fault_of(sighting, points_mm)
        if fault:
            return f"the {camera} camera {fault}"
    return ""
