"""Calibration targets: where the printed pattern is black, and the points a camera can find on it.

Board frame, mm: the origin is the first point, x runs along a row, y down the rows and z into the
board, away from who looks at it. The order of the points is OpenCV's for each family. A new family
is a frozen dataclass that derives from `simtip.target.target.Target`, in a file of its own.
"""

from simtip.target.charuco import Charuco
from simtip.target.chessboard import Chessboard
from simtip.target.circles import AsymmetricCircles, CircleGrid
from simtip.target.parse import parse_target
from simtip.target.sighting import Sighting
from simtip.target.target import Lattice, Target

__all__ = [
    "AsymmetricCircles",
    "Charuco",
    "Chessboard",
    "CircleGrid",
    "Lattice",
    "Sighting",
    "Target",
    "parse_target",
]
