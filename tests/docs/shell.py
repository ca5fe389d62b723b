"""Shell blocks of the documentation, run line by line in the reader's folder."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from pathlib import Path

from asked import call
from pages import ROOT, Block
from small_scenes import quarter

from simtip.scene_file import dump_scene, load_scene

PLACEHOLDER = re.compile(r"DIR\d?")
"""Names of folders that stand for any new one."""

VIEWS = "4"
"""Of calibration boards, in place of those that a page asks of scenes/."""

WHOLE = {"boards", "kalibr"}
"""Words of commands that want whole images, of fewer pixels, and not a region of them."""


def lines_of(text: str) -> list[list[str]]:
    """Give the lines of a shell block as words, comments left out, continued lines joined.

    Of a shell's operators only ``> FILE`` is known: the last two words are then ``>`` and its file.
    """
    lines = []
    for line in re.sub(r"\\\n", " ", text).splitlines():
        lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
        lexer.whitespace_split = True
        words = list(lexer)
        operators = [word for word in words if set(word) <= set("();<>|&")]
        assert operators in ([], [">"]), f"{line}: operators of a shell other than one >"
        assert not operators or words[-2] == ">", f"{line}: something follows the file"
        if words:
            lines.append(words)
    return lines


def run(block: Block, folder: Path) -> str:
    """Run a block, stop at the first line that fails, and give what its lines printed."""
    said = ""
    for words in lines_of(block.text):
        line = f"{block.place}: {shlex.join(words)}"
        assert words[0] in COMMANDS, f"{line}: unknown command"
        into = words[-1] if len(words) > 2 and words[-2] == ">" else None
        out = COMMANDS[words[0]](words[:-2] if into else words, folder, line)
        if into:
            (folder / into).write_text(out, encoding="utf-8")
        said += out
    return said


def simtip(words: list[str], folder: Path, line: str) -> str:
    """Call simtip in this process."""
    words = smaller(words, folder)
    if "-o" in words:
        out = words[words.index("-o") + 1]
        if PLACEHOLDER.fullmatch(out):
            shutil.rmtree(folder / out, ignore_errors=True)
    answer = call(*words[1:])
    assert answer.code == 0, f"{line}: exit code {answer.code}: {answer.err}"
    return answer.out


def smaller(words: list[str], folder: Path) -> list[str]:
    """Ask for less of what takes long: fewer views, samples and replicates."""
    words = list(words)
    of_ours = words[2:] and (words[2] == "SCENE" or words[2].startswith("scenes/"))
    if WHOLE & set(words) and of_ours:
        name = "scenes/01_single_tip.yaml" if words[2] == "SCENE" else words[2]
        whole = folder / "whole.yaml"
        whole.write_text(dump_scene(quarter(load_scene(ROOT / name))), encoding="utf-8")
        words[2] = whole.name
        if "--views" in words:
            words[words.index("--views") + 1] = VIEWS
    if words[1] == "bound":
        words += ["--samples", "16"]
    if words[1] == "budget":
        words += ["--replicates", "2"]
    return words


def compiler(words: list[str], folder: Path, line: str) -> str:
    """Compile, with warnings as errors."""
    return program([*words, "-Wall", "-Wextra", "-Werror"], folder, line)


def program(words: list[str], folder: Path, line: str) -> str:
    """Run another program."""
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{line}: exit code {done.returncode}: {done.stderr}"
    return done.stdout


def make(words: list[str], folder: Path, line: str) -> str:  # noqa: ARG001 (as the others)
    """Look whether a target exists and the whole check makes it, which no test could."""
    (target,) = words[1:]
    assert f"\n{target}:" in (ROOT / "Makefile").read_text(encoding="utf-8"), line
    assert f"make {target}\n" in (ROOT / ".ci" / "run").read_text(encoding="utf-8"), line
    return ""


COMMANDS = {"simtip": simtip, "c++": compiler, "make": make}
"""All that the documentation may ask a shell for."""
