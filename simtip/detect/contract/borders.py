"""Cases with a needle whose tip lies beyond a border, or only just inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.detect.contract.case import Case, Verdict
from simtip.detect.contract.drawing import Needle
from simtip.detect.contract.needles import SHAPE, plain
from simtip.detect.contract.probe import Probe

END_PX = 32.0
"""How far from the end in sight a tip may be claimed: a needle's width and a little."""


@dataclass(frozen=True)
class EndAtBorder:
    """Judges one needle: no tip, or one near the end that can be seen at `end_px` (u, v)."""

    needle: Needle
    end_px: tuple[float, float]

    def __call__(self, probe: Probe) -> Verdict:
        """Ask and judge."""
        seen = probe.see(plain(self.needle))
        if seen.tip_px is None:
            return Verdict(passed=True, seen=f"no tip: {seen.reason}")
        away = float(np.linalg.norm(seen.tip_px - np.array(self.end_px)))
        return Verdict(away <= END_PX, f"a tip {away:.0f} px from the end in sight")


_HEIGHT, _WIDTH = SHAPE

BORDER_CASES = (
    Case(
        "needle cut off at the bottom",
        EndAtBorder(Needle((150.3, _HEIGHT + 60.0)), (150.3, _HEIGHT - 1.0)),
    ),
    Case(
        "needle cut off at the left",
        EndAtBorder(Needle((-60.0, 260.0), degrees=-45), (0.0, 200.0)),
    ),
    Case(
        "needle cut off at the right",
        EndAtBorder(Needle((_WIDTH + 60.0, 260.0), degrees=-135), (_WIDTH - 1.0, 199.0)),
    ),
    Case("only its tip in sight at the top", EndAtBorder(Needle((150.3, 20.4)), (150.3, 20.4))),
)
