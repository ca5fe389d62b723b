"""Where the files lie that a test names."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from simtip.errors import InputError


@dataclass(frozen=True)
class Places:
    """The folders from which the files that a test names count, the first before the second.

    Attributes
    ----------
    beside
        Folder of the test's file.
    root
        Root folder of all tests.
    """

    beside: Path
    root: Path

    @classmethod
    def of(cls, node: pytest.Item | pytest.Collector, config: pytest.Config) -> Places:
        """Give those of a test."""
        return cls(node.path.parent, config.rootpath)

    def find(self, name: str | Path, what: str, field: str | None = None) -> Path:
        """Find a file; `field` says who named it.

        Raises
        ------
        InputError
            There is none; it says where it was looked for.
        """
        tried = list(dict.fromkeys((self.beside / name, self.root / name)))
        for path in tried:
            if _is_file(path):
                return path
        if Path(name).is_absolute():
            where = ""
        elif len(tried) == 1:
            where = f" in {self.root}"
        else:
            where = f", neither in {self.beside} nor in {self.root}"
        raise InputError(
            f"there is no {what} {str(name)!r}{where}",
            field=field,
            remedy="name a file in one of the two" if len(tried) > 1 else "name another file",
        )


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that is too long, or a folder that may not be looked into
        return False
