"""Are sizes read as they are meant, and shown so that they can be read again?"""

from __future__ import annotations

import pytest

from simtip.errors import InputError
from simtip.sweep.sizes import parse_size, shown_size


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("0", 0),
        ("0B", 0),
        ("512B", 512),
        ("1kB", 1000),
        ("20GB", 20_000_000_000),
        (" 1.5 GB ", 1_500_000_000),
        ("5gb", 5_000_000_000),
        ("2TB", 2 * 10**12),
        ("1MB", 10**6),
        ("1KiB", 1024),
        ("1kib", 1024),
        ("1.5MiB", 3 * 2**19),
        ("3GiB", 3 * 2**30),
        ("1TiB", 2**40),
        ("0.1GB", 10**8),
        ("0.0001B", 0),
    ],
)
def test_a_size_is_read(text, size):
    assert parse_size(text) == size


BAD = [
    "", "GB", "20", "-1GB", "+1GB", "1e3GB", "nan GB", "inf", "20 G", "1,5GB", "1.GB", ".5GB",
    "20GBB", "1PB", "1iB", "20GB\n20GB", "\u0662GB", "9" * 5000 + "GB", "0x10B", "1 k B",
]  # fmt: skip


@pytest.mark.parametrize("text", BAD, ids=lambda t: ascii(t)[:20])
def test_anything_else_is_refused(text):
    with pytest.raises(InputError, match="is no size") as caught:
        parse_size(text)
    assert caught.value.field == "--cache-size"


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (0, "0 B"),
        (999, "999 B"),
        (1000, "1 kB"),
        (1530, "1.53 kB"),
        (999_499, "999 kB"),
        (999_500, "1 MB"),
        (20_000_000_000, "20 GB"),
        (999_600_000_000, "1 TB"),
        (12_345 * 10**12, "12345 TB"),
    ],
)
def test_a_size_is_shown(size, text):
    assert shown_size(size) == text
    assert parse_size(text) == pytest.approx(size, rel=5e-3)
