"""Make the stored crops of scenes anew: all of them, or those whose names begin as given.

python tests/scenes/make_references.py [NAME ..]
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1])]

from stored_crops import FOLDER, SCENES, file_of, made, save  # noqa: E402 (the path comes first)


def main(names: list[str]) -> None:
    """Render and store them."""
    FOLDER.mkdir(exist_ok=True)
    for path in SCENES:
        if not names or any(path.stem.startswith(name) for name in names):
            save(made(path), file_of(path))
            sys.stdout.write(f"{file_of(path)}: {file_of(path).stat().st_size / 1e3:.0f} kB\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
