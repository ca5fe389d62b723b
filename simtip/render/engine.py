"""The one door to Dr.Jit and Mitsuba: `from simtip.render.engine import dr, mi`.

Dr.Jit loads an LLVM library as soon as it is imported, whichever is found first, and a bad one
aborts the process later. So the library is chosen before the import.
"""

from __future__ import annotations

from typing import Any

from simtip.render.backend import settle_llvm

settle_llvm()

import drjit  # noqa: E402 (the choice of LLVM comes first)
import mitsuba  # noqa: E402

# Untyped: which types the two have depends on the variant that is active at the time.
dr: Any = drjit
mi: Any = mitsuba
