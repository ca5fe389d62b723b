"""Turn an image so that its needle hangs tip down, and turn results back.

Only whole turns and reflections: pixels stay pixels, nothing is interpolated.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from simtip.geometry import Array


@dataclass(frozen=True)
class Frame:
    """A reflection of the image plane that makes a direction point down.

    Attributes
    ----------
    swap
        Exchange u and v first.
    flip
        Then turn v upside down.
    height
        Of the turned image, px.
    """

    swap: bool
    flip: bool
    height: int

    @classmethod
    def down(cls, direction: Array, shape: tuple[int, ...]) -> Frame:
        """Give the frame in which a direction (2,) points down, within 45 degrees.

        `shape` is the image's, (H, W, ...).
        """
        u, v = direction
        swap = bool(abs(u) > abs(v))
        return cls(swap, bool((u if swap else v) < 0), shape[1] if swap else shape[0])

    def view(self, image: NDArray[Any]) -> NDArray[Any]:
        """Turn an image (H, W) or (H, W, 3): a view, no copy."""
        turned = image.swapaxes(0, 1) if self.swap else image
        return turned[::-1] if self.flip else turned

    def points(self, points: Array) -> Array:
        """Turn points (..., 2) u, v of the image."""
        turned = points[..., ::-1].copy() if self.swap else points.copy()
        if self.flip:
            turned[..., 1] = self.height - 1 - turned[..., 1]
        return turned

    def points_back(self, points: Array) -> Array:
        """Turn points (..., 2) back."""
        back = points.copy()
        if self.flip:
            back[..., 1] = self.height - 1 - back[..., 1]
        return back[..., ::-1].copy() if self.swap else back

    def vectors(self, vectors: Array) -> Array:
        """Turn directions (..., 2)."""
        turned = vectors[..., ::-1].copy() if self.swap else vectors.copy()
        if self.flip:
            turned[..., 1] = -turned[..., 1]
        return turned

    def vectors_back(self, vectors: Array) -> Array:
        """Turn directions (..., 2) back."""
        back = vectors.copy()
        if self.flip:
            back[..., 1] = -back[..., 1]
        return back[..., ::-1].copy() if self.swap else back
