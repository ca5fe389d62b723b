"""One table of Owen-scrambled Sobol points, and the numbers that make it.

They are those of `scipy.stats.qmc.Sobol`, drawn once: to load SciPy's statistics takes longer than
many a render.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

COLUMNS = 7
TABLE_POINTS = 1 << 14
TABLE_SEED = 10
"""Of 16 the best for smooth light from few points, and for edges through a lens; at plain edges all
are equal to 5 %."""

# fmt: off
SCRAMBLED = (
    (0x5a2215dc, 0x8d2d8f48, 0x68097cf0, 0x345f6e78, 0x1745a2f4, 0x0bd7e058, 0x05d25468, 0x034ecdec,
     0x0120239c, 0x0091762c, 0x005e397c, 0x0039b988, 0x00106ae8, 0x000d4238, 0x0005dd78),
    (0xbbc68fec, 0xb9b1da70, 0xd17991c4, 0x87f32b10, 0xf6a6c0a0, 0xb2561250, 0xdc0e4574, 0x8ebbb5dc,
     0xf8b0473c, 0xb91ad6b8, 0xd19ee5c8, 0x8772dd6c, 0xf67cec24, 0xb2f30ac4, 0xdce14eb8),
    (0xb483cb60, 0xe5baa9a4, 0xb2719290, 0x7d6a05a0, 0xfda64d00, 0x912d1524, 0x423b8724, 0xea81e018,
     0xb7c60698, 0x746235bc, 0xf0d875a8, 0x97a46348, 0x4a87a3f4, 0xe5ff54b0, 0xb2980c10),
    (0xfd51bcf4, 0x8e40b0b0, 0xca4ee434, 0x2f960c58, 0x51dbd3ac, 0xf85230c0, 0x78dc34fc, 0xa2a58e7c,
     0x99982d28, 0xd70b32a0, 0x2824e0d0, 0x585c26d4, 0xe0bac6f0, 0x761fbc78, 0xb298b7dc),
    (0xf7705560, 0xc3b4fc80, 0x48c186e4, 0x307c2484, 0xe5cdacbc, 0xa4642508, 0x9381f7b8, 0x640b2db4,
     0xda0fc3f4, 0x54ef0ef4, 0x3cf79d10, 0xf2d15830, 0xada9df48, 0x975437fc, 0x7430d3a8),
    (0x5f274fb8, 0x9eb1f958, 0x73ac8e74, 0x401a12a4, 0x2db42618, 0xe63404b8, 0x3778a700, 0x6a99e144,
     0xc959a4e8, 0xde255638, 0x5e7ab144, 0xa67a20b8, 0x1ae3c1e4, 0x8c4bcd28, 0xfe13a128),
    (0x60349964, 0x9a0b14a0, 0xcb39c064, 0xbeef66d4, 0xd1942fec, 0x4317b61c, 0x85f1abc8, 0x30ace888,
     0xed7c1a9c, 0xaa2389f0, 0x2695cf70, 0x147f1bb0, 0xf7c8b8b8, 0x57296878, 0x72a18d3c),
)
# fmt: on
"""Of each column the first point and, of its direction numbers, as many as the table's size takes;
all as 32-bit fractions."""


@cache
def table() -> NDArray[np.uint32]:
    """Give (COLUMNS, TABLE_POINTS) scrambled Sobol points as 32-bit fractions.

    In the order of the Gray code: each point differs from the one before by one direction number.
    """
    index = np.arange(TABLE_POINTS, dtype=np.uint32)
    gray = index ^ (index >> 1)
    numbers = np.array(SCRAMBLED, np.uint32)
    bits = np.repeat(numbers[:, :1], TABLE_POINTS, axis=1)
    for k in range(numbers.shape[1] - 1):
        bits ^= (gray >> k & 1) * numbers[:, k + 1, None]
    return bits
