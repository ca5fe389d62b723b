"""The two kinds of numbers that the steps work in."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Real = TypeVar("Real", np.float32, np.float64)
Array = NDArray[np.float64]
