"""Does the reader of the documentation see what is wrong with a page?"""

from __future__ import annotations

import sys

import pytest
import shown_files
from pages import Block, blocks_in
from reader import read
from shell import Line, lines_of


def page(*blocks: str) -> list[Block]:
    return blocks_in("\n\n".join(blocks), "page.md")


def shown(language: str, text: str, said: str = "") -> str:
    return f"{said}```{language}\n{text}\n```"


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))


def test_a_block_has_its_place_language_and_comment():
    (block,) = page("text", shown("sh", "simtip doctor", "<!-- not run: because -->\n"))
    assert (block.place, block.language, block.not_run) == ("page.md:4", "sh", "because")
    (block,) = page(shown("yaml", "a: 1", "<!-- file: x.yaml -->\n"))
    assert (block.file, block.text) == ("x.yaml", "a: 1\n")


def test_a_block_that_is_not_closed_is_told():
    with pytest.raises(AssertionError, match=r"page\.md:1: a block is not closed"):
        page("```sh\nsimtip doctor")


def test_lines_are_split_as_a_shell_does():
    text = "simtip run 'a b' \\\n  --json > out.json  # so\n\nsimtip cache"
    first, second = lines_of(text)
    assert first == Line(["simtip", "run", "a b", "--json", ">", "out.json"])
    assert (first.into, second.words, second.into) == ("out.json", ["simtip", "cache"], None)


def test_a_command_that_is_meant_to_fail_has_to(tmp_path):
    read(page(shown("sh", "simtip run none.yaml  # exit code 2: there is no such file")), tmp_path)
    with pytest.raises(AssertionError, match="exit code 0"):
        read(page(shown("sh", "simtip --version  # exit code 1")), tmp_path)


@pytest.mark.parametrize("line", ["simtip a | b", "simtip a && simtip b", "simtip > a b", "a < b"])
def test_what_only_a_shell_could_do_is_refused(line):
    with pytest.raises(AssertionError):
        lines_of(line)


def test_an_unknown_command_is_told(tmp_path):
    with pytest.raises(AssertionError, match="curl x: unknown command"):
        read(page(shown("sh", "curl x")), tmp_path)


def test_the_first_line_that_fails_ends_the_page(tmp_path):
    text = shown("sh", "simtip schema > one.json\nsimtip run none.yaml\nsimtip schema > two.json")
    with pytest.raises(AssertionError, match=r"page\.md:1: simtip run none\.yaml: exit code 2"):
        read(page(text), tmp_path)
    assert (tmp_path / "one.json").exists()
    assert not (tmp_path / "two.json").exists()


def test_a_target_of_make_has_to_be_one_that_the_whole_check_makes(tmp_path):
    read(page(shown("sh", "make test")), tmp_path)
    for target in ("clean", "nothing"):
        with pytest.raises(AssertionError, match=f"make {target}"):
            read(page(shown("sh", f"make {target}")), tmp_path)


def test_python_of_one_page_shares_its_names_and_fails_aloud(tmp_path):
    read(page(shown("python", "a = 1"), shown("python", "assert a == 1")), tmp_path)
    with pytest.raises(NameError):
        read(page(shown("python", "a")), tmp_path)


def test_a_file_is_there_for_what_follows_and_forgotten_afterwards(tmp_path):
    module = shown("python", "x = 2", "<!-- file: told.py -->\n")
    read(page(module, shown("python", "import told\nassert told.x == 2")), tmp_path)
    assert "told" not in sys.modules


def test_what_is_said_to_be_printed_has_to_be(tmp_path):
    command = shown("sh", "simtip --version")
    read(page(command, shown("text", "simtip 9.9.9")), tmp_path)
    with pytest.raises(AssertionError, match=r"shows \['colour'\]"):
        read(page(command, shown("text", "simtip colour")), tmp_path)
    read(page(command, "With another version:", shown("text", "simtip colour")), tmp_path)
    schema = shown("sh", "simtip schema")
    read(page(schema, shown("json", '{"properties": {"needle": {}}}')), tmp_path)
    with pytest.raises(AssertionError, match=r"shows \['needles'\]"):
        read(page(schema, shown("json", '{"properties": {"needles": {}}}')), tmp_path)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("needle: {roll_deg: 30}", "part of a scene"),
        ("scene: s.yaml\nfactors: {needle.roll_deg: [1, 2]}", "sweep"),
        ("name: x\nscene: s.yaml\ncases: [{name: a}]", "suite"),
    ],
)
def test_a_file_shown_is_checked_as_what_it_is(text, kind, tmp_path):
    (tmp_path / "s.yaml").write_bytes(shown_files.BASE.read_bytes())
    (block,) = page(shown("yaml", text))
    assert shown_files.check(block, tmp_path) == kind
    for right, wrong in (("roll_deg", "rol_deg"), ("name: a", "nam: a")):
        (block,) = page(shown("yaml", text.replace(right, wrong)))
        if right in text:
            with pytest.raises(Exception, match=r"roll_deg|name"):
                shown_files.check(block, tmp_path)
