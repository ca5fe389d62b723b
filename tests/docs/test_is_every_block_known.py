"""Is every block of the documentation of a kind that is checked, and is it well formed?"""

from __future__ import annotations

import re
import shutil
from functools import cache

import pytest
import shell
import shown_files
from pages import COMMENT, PAGES, ROOT, Block, blocks_of
from typer.main import get_command

from simtip.cli import app

BLOCKS = [block for page in PAGES for block in blocks_of(page)]
LANGUAGES = {"sh", "python", "cpp", "yaml", "toml", "json", "text"}

NOT_RUN = {
    ("README.md", "installs; make demo does the same"),
    ("README.md", "installs; make test does the same"),
    ("docs/calibration.md", "photographs of your own"),
    ("docs/pytest.md", "the standard suite takes minutes; tests/pytest_plugin runs these"),
    ("docs/regress.md", "the standard suite takes minutes; the tutorial runs these on a small one"),
    ("docs/report.md", "a trial of a sweep that is not told"),
    ("docs/your_detector.md", "MATLAB is somebody else's program"),
}
"""All that is shown and not run."""


def of(*languages: str) -> list[Block]:
    return [block for block in BLOCKS if block.language in languages]


def place(block: Block) -> str:
    return block.place


@pytest.fixture
def folder(tmp_path):
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")
    return tmp_path


def test_every_block_is_of_a_kind_that_is_checked():
    assert {
        block.place: block.language for block in BLOCKS if block.language not in LANGUAGES
    } == {}


def test_what_is_not_run_is_listed_here():
    assert {(block.page, block.not_run) for block in BLOCKS if block.not_run} == NOT_RUN


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_comment_before_a_block_is_understood(page):
    lines = page.read_text(encoding="utf-8").splitlines()
    for block in blocks_of(page):
        before = lines[block.line - 2] if block.line > 1 else ""
        assert not before.lstrip().startswith("<!--") or COMMENT.match(before), block.place


@pytest.mark.parametrize("block", of("yaml", "json", "toml"), ids=place)
def test_every_file_shown_is_what_it_should_be(block, folder):
    assert shown_files.check(block, folder)


def test_every_kind_of_file_is_shown_somewhere(folder):
    kinds = {shown_files.check(block, folder) for block in of("yaml")}
    assert {"scene", "part of a scene", "sweep"} <= kinds


def test_every_program_shown_is_a_file_that_a_command_compiles():
    lines = [line.words for block in of("sh") for line in shell.lines_of(block.text)]
    compiled = [words for words in lines if words[0] == "c++"]
    for block in of("cpp"):
        assert any(block.file in words for words in compiled), block.place


@pytest.mark.parametrize("block", of("sh"), ids=place)
def test_every_command_shown_exists_and_has_these_options(block):
    if block.not_run:
        return
    for line in shell.lines_of(block.text):
        words = line.words
        assert words[0] in shell.COMMANDS, f"{block.place}: {words[0]}"
        if words[0] == "simtip":
            wrong = [word for word in words if is_option(word) and word not in options(words)]
            assert not wrong, f"{block.place}: {' '.join(words)} has no {wrong}"


def is_option(word: str) -> bool:
    return re.fullmatch(r"--?[a-zA-Z][\w-]*", word) is not None


def options(words: list[str]) -> set[str]:
    """Give the options of the command that the words begin with, its group's included."""
    command, found = get_command(app), set()
    for word in words[1:]:
        found |= {name for parameter in command.params for name in parameter.opts}
        if word not in getattr(command, "commands", {}):
            break
        command = command.commands[word]
    return found | {name for parameter in command.params for name in parameter.opts} | {"--help"}


@cache
def commands_shown() -> frozenset[str]:
    lines = [line.words for block in of("sh") for line in shell.lines_of(block.text)]
    return frozenset(words[1] for words in lines if words[0] == "simtip")


def test_every_command_there_is_is_shown_somewhere():
    assert set(get_command(app).commands) <= commands_shown()
