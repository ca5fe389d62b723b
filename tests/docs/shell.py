"""Shell blocks of the documentation, run line by line in the reader's folder."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from unittest import mock

from asked import Answer, call
from one_process import workers_here
from pages import ROOT, Block
from pytest_plugin.a_users_tests import PLUGIN
from regress.small_suites import fixed_ratio
from small_scenes import quarter

from simtip.scene_file import dump_scene, load_scene

PLACEHOLDER = re.compile(r"DIR\d?")
"""Names of folders that stand for any new one."""
WRITTEN = {"-o", "--overlay"}
"""Options that name a new folder."""

EXIT_CODE = re.compile(r"#.*\bexit code (\d)")
"""What a comment says of a command that is meant to fail."""

VIEWS = "3"
"""Of calibration boards, in place of those that a page or its scene asks for."""

WHOLE = {"boards", "rig"}
"""Commands that want whole images, of fewer pixels, and not a region of them."""


@dataclass(frozen=True)
class Line:
    """A command line: its words, and the exit code that its comment says, 0 if none.

    Of a shell's operators only ``> FILE`` is known: the last two words are then ``>`` and its file.
    """

    words: list[str]
    code: int = 0

    @property
    def into(self) -> str | None:
        """The file that gets what it prints."""
        return self.words[-1] if len(self.words) > 2 and self.words[-2] == ">" else None


def lines_of(text: str) -> list[Line]:
    """Give the lines of a shell block, comments left out, continued lines joined."""
    lines = []
    for line in re.sub(r"\\\n", " ", text).splitlines():
        lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
        lexer.whitespace_split = True
        words = list(lexer)
        operators = [word for word in words if set(word) <= set("();<>|&")]
        assert operators in ([], [">"]), f"{line}: operators of a shell other than one >"
        assert not operators or words[-2] == ">", f"{line}: something follows the file"
        if words:
            code = EXIT_CODE.search(line)
            lines.append(Line(words, int(code[1]) if code else 0))
    return lines


def run(block: Block, folder: Path) -> str:
    """Run a block, stop at the first line that fails, and give what its lines printed."""
    said = ""
    for line in lines_of(block.text):
        place = f"{block.place}: {shlex.join(line.words)}"
        assert line.words[0] in COMMANDS, f"{place}: unknown command"
        words = line.words[:-2] if line.into else line.words
        answer = COMMANDS[words[0]](words, folder)
        assert answer.code == line.code, (
            f"{place}: exit code {answer.code}: {answer.err or answer.out}"
        )
        if line.into:
            (folder / line.into).write_text(answer.out, encoding="utf-8")
        said += answer.out
    return said


def simtip(words: list[str], folder: Path) -> Answer:
    """Call simtip, workers and all, in this process."""
    words = smaller(words, folder)
    with workers_here(), quicker():
        prepare(words, folder)
        for option, out in pairwise(words):
            if option in WRITTEN and PLACEHOLDER.fullmatch(out):
                shutil.rmtree(folder / out, ignore_errors=True)
        return call(*words[1:])


@contextmanager
def quicker() -> Iterator[None]:
    """Let detectors be timed with a fixed clock, and few pixels of a sensor be measured."""
    with (
        mock.patch("simtip.regress.timing.ratio_of", fixed_ratio),
        mock.patch("simtip.bench_camera.SIDE_PX", 48),
    ):
        yield


def prepare(words: list[str], folder: Path) -> None:
    """Make what a placeholder stands for, where a line reads one."""
    if words[1] in {"export", "view", "report"} and "DIR" in words:
        shutil.rmtree(folder / "DIR", ignore_errors=True)
        call("run", "SCENE", "-o", "DIR")
    if "SWEPT" in words and words[1] != "sweep" and not (folder / "SWEPT").exists():
        call("sweep", "SWEEP", "-o", "SWEPT")


def smaller(words: list[str], folder: Path) -> list[str]:
    """Ask for less of what takes long: fewer views, samples, replicates and cases."""
    words = list(words)
    of_ours = words[2:] and (words[2] == "SCENE" or words[2].startswith("scenes/"))
    if words[1] in WHOLE and of_ours:
        name = "scenes/01_single_tip.yaml" if words[2] == "SCENE" else words[2]
        whole = folder / "whole.yaml"
        whole.write_text(dump_scene(quarter(load_scene(ROOT / name))), encoding="utf-8")
        words[2] = whole.name
    if words[1] == "boards":
        if "--views" not in words:
            words += ["--views", VIEWS]
        words[words.index("--views") + 1] = VIEWS
    if words[1] == "bound":
        words += ["--samples", "8"]
    if words[1] == "budget":
        words += ["--replicates", "2"]
    if words[1:4] == ["regress", "record", "standard"]:
        words[3] = "SUITE"
    if words[1] == "view" and "--save" not in words:  # there may be no display
        words += ["--save", "seen.rrd"]
    return words


def compiler(words: list[str], folder: Path) -> Answer:
    """Compile, with warnings as errors."""
    return program([*words, "-Wall", "-Wextra", "-Werror"], folder)


def pytest(words: list[str], folder: Path) -> Answer:
    """Run pytest by this Python."""
    return program([sys.executable, "-m", words[0], *PLUGIN, *words[1:]], folder)


def program(words: list[str], folder: Path) -> Answer:
    """Run another program."""
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    return Answer(done.returncode, done.stdout, done.stderr)


def make(words: list[str], folder: Path) -> Answer:  # noqa: ARG001 (as the others)
    """Look whether a target exists and the whole check makes it, which no test could."""
    (target,) = words[1:]
    exists = f"\n{target}:" in (ROOT / "Makefile").read_text(encoding="utf-8")
    checked = f"make {target}\n" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    return Answer(0 if exists and checked else 2, "", "no target, or none that .ci/run makes")


COMMANDS = {"simtip": simtip, "c++": compiler, "pytest": pytest, "make": make}
"""All that the documentation may ask a shell for."""
