"""Does the README show every command, and do all pages name things that exist?"""

from __future__ import annotations

import re

import pytest
import shell
from pages import PAGES, ROOT, blocks_of

from simtip.cli import app

MARKDOWN = [*PAGES, ROOT / "CHANGELOG.md"]


def test_every_command_is_shown():
    blocks = [block for block in blocks_of(ROOT / "README.md") if block.language == "sh"]
    lines = [line.words for block in blocks for line in shell.lines_of(block.text)]
    assert {words[1] for words in lines if words[0] == "simtip"} == {
        *(command.name or command.callback.__name__ for command in app.registered_commands),
        *(group.name for group in app.registered_groups),
    }


@pytest.mark.parametrize("page", MARKDOWN, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (page.parent / link).exists()]
    assert not missing


def test_every_test_that_the_docs_name_exists():
    for page in MARKDOWN:
        for name in re.findall(r"`(tests/[\w/.]+)", page.read_text(encoding="utf-8")):
            assert (ROOT / name).exists(), f"{page.name} names {name}"
