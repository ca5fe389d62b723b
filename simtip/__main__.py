"""``python -m simtip``."""

from simtip.cli import main

main()
