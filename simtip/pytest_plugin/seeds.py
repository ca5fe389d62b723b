"""Seeds of the noise that tests give, and that of the command line."""

from __future__ import annotations

import numpy as np

from simtip.errors import InputError
from simtip.seeding import SEED_LIMIT, seed32


def require_seed(seed: object, field: str) -> int:
    """Refuse a seed that is none.

    Raises
    ------
    InputError
        It is no whole number, or out of range.
    """
    if isinstance(seed, int | np.integer) and not isinstance(seed, bool):
        whole = int(seed)
        if 0 <= whole < SEED_LIMIT:
            return whole
    raise InputError(f"is {seed!r}", field=field, remedy="give a whole number from 0 to 2**63 - 1")


def noise_seed(own: int | None, fresh: int | None) -> int | None:
    """Give the seed of a pair's noise.

    Parameters
    ----------
    own
        That the test gives; None is the scene's.
    fresh
        That of the command line, which draws everything anew; what a test gives still tells its
        pairs apart.
    """
    if own is None or fresh is None:
        return own if fresh is None else fresh
    return seed32(fresh, "pytest", own)
