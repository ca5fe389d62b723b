"""The pages of the documentation, and the code blocks in them.

A block is fenced by three backticks and says its language. A comment on the line before it may say
more: ``<!-- file: NAME -->``, it is a file of this name in the reader's folder; ``<!-- not run:
REASON -->``, it cannot be run in a test. A block of text or JSON that follows a shell's, with
nothing between the two, is what that one prints.
"""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]

FENCE = re.compile(r"^ *```(?P<language>.*)$")
COMMENT = re.compile(r"^ *<!-- (?P<key>file|not run): (?P<value>.+) -->$")


@dataclass(frozen=True)
class Block:
    """A code block.

    Attributes
    ----------
    page
        Its page's path from the repository's root.
    line
        Of its fence, from 1.
    language
        As written behind the fence.
    text
        What is in it.
    file
        Name of the file that it is; None: it is none.
    not_run
        Why it cannot be run; None: it can.
    follows
        Whether nothing but blank lines stands between the block before and this one.
    """

    page: str
    line: int
    language: str
    text: str
    file: str | None = None
    not_run: str | None = None
    follows: bool = False

    @property
    def place(self) -> str:
        """Where it is, for people."""
        return f"{self.page}:{self.line}"


def blocks_of(page: Path) -> list[Block]:
    """Give a page's blocks in their order."""
    return blocks_in(page.read_text(encoding="utf-8"), page.relative_to(ROOT).as_posix())


def blocks_in(text: str, page: str) -> list[Block]:
    """Give the blocks of a page's text."""
    lines = text.splitlines()
    found: list[Block] = []
    opened: int | None = None
    closed: int | None = None
    for number, line in enumerate(lines):
        fence = FENCE.match(line)
        if fence is None:
            continue
        if opened is None:
            opened = number
            continue
        assert not fence["language"], f"{page}:{number + 1}: a block opens within a block"
        said = COMMENT.match(lines[opened - 1]) if opened else None
        hint = {said["key"]: said["value"]} if said else {}
        found.append(
            Block(
                page,
                opened + 1,
                FENCE.match(lines[opened])["language"].strip(),
                textwrap.dedent("\n".join(lines[opened + 1 : number])) + "\n",
                hint.get("file"),
                hint.get("not run"),
                follows=closed is not None and not "".join(lines[closed + 1 : opened]).strip(),
            )
        )
        opened, closed = None, number
    assert opened is None, f"{page}:{opened + 1}: a block is not closed"
    return found
