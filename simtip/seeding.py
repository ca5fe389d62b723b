"""One root seed, many independent streams, each found by its name and not by its turn.

A stream depends on the root seed and on its names alone, so neither the number of workers nor the
order of asking changes a result. Names are digested by SHA-256 into the spawn key of a
`numpy.random.SeedSequence`: the same on every machine and in every process. The bits are therefore
fixed for ever; what NumPy's distributions make of them may change with NumPy's version (NEP 19).
"""

from __future__ import annotations

import hashlib

import numpy as np

SEED_LIMIT = 2**63


def stream(seed: int, *names: str | int) -> np.random.Generator:
    """Give the random stream of a name, e.g. ``stream(seed, "trial", 17, "sensor", "left")``.

    Parameters
    ----------
    seed
        Root seed, 0 to 2**63 - 1.
    names
        Path of the stream, texts and whole numbers; ``1`` and ``"1"`` differ.

    Returns
    -------
    generator
        Over SFC64, at its beginning: asking twice gives the same numbers twice.

    Raises
    ------
    ValueError
        The seed is out of range.
    TypeError
        The seed is no whole number, or a name neither text nor whole number.
    """
    return np.random.Generator(np.random.SFC64(_sequence("stream", seed, names)))


def seed32(seed: int, *names: str | int) -> int:
    """Give a 32-bit seed of its own for a name, for libraries that take no generator.

    Two names share a seed with a chance of 2**-32. Parameters and errors are those of `stream`.
    """
    return int(_sequence("seed32", seed, names).generate_state(1, np.uint32)[0])


def _sequence(use: str, seed: int, names: tuple[str | int, ...]) -> np.random.SeedSequence:
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise TypeError(f"a seed is a whole number, not {seed!r}")
    if not 0 <= seed < SEED_LIMIT:
        raise ValueError(f"a seed lies between 0 and 2**63 - 1, not {seed}")
    digest = hashlib.sha256(b"".join(_encode(name) for name in (use, *names))).digest()
    words = tuple(int(w) for w in np.frombuffer(digest, dtype="<u4"))
    return np.random.SeedSequence(int(seed), spawn_key=words)


def _encode(name: str | int) -> bytes:
    """Write a name so that no two lists of names read alike: kind, length, content."""
    if isinstance(name, str):
        kind, content = b"s", name.encode()
    elif isinstance(name, int | np.integer) and not isinstance(name, bool):
        kind, content = b"i", str(int(name)).encode()
    else:
        raise TypeError(f"a stream's name is text or a whole number, not {name!r}")
    return kind + len(content).to_bytes(8, "little") + content
