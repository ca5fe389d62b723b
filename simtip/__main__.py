"""The command line, as ``simtip`` and as ``python -m simtip``."""

from __future__ import annotations

import sys

from simtip import interrupts


def main() -> None:
    """Run the command line; see `simtip.cli.main`. Ctrl-C is one line from the first moment on."""
    interrupts.take_over()
    try:
        from simtip.cli import main as run

        interrupts.let_clean_up()
        run()
    except KeyboardInterrupt:  # just before or after what says so itself
        interrupts.no_more()
        sys.stderr.write(f"simtip: {interrupts.NOTHING_WRITTEN}\n")
        sys.exit(interrupts.INTERRUPTED)
    finally:
        interrupts.no_more()


if __name__ == "__main__":
    main()
