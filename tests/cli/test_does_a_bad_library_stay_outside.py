"""An LLVM library that aborts never does so in the user's process.

First with a stand-in for the trial process, which works everywhere; then, marked slow, with real
libraries: those of this machine that Dr.Jit cannot use, a text file and a missing path.
"""

from __future__ import annotations

import json
import os
import stat
import sys
from pathlib import Path

import pytest
from command_line import in_a_process, lay_out, one_line

import simtip.doctor
from simtip.errors import BackendError
from simtip.render import backend
from simtip.render.libllvm import Candidate

posix = pytest.mark.skipif(os.name != "posix", reason="the stand-in is a shell script")

CALL = "from simtip.cli import main; main()"


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """No memory of former trials, neither in this process nor on disk, and no Dr.Jit loaded."""
    monkeypatch.setattr(backend, "_memo_path", lambda: tmp_path / "cache" / "trials.json")
    monkeypatch.setattr(backend, "gpu_present", lambda: False)
    monkeypatch.delitem(sys.modules, "drjit", raising=False)
    monkeypatch.delenv("SIMTIP_BACKEND", raising=False)
    caches = (backend._first_llvm, backend.try_cuda)
    for cache in caches:
        cache.cache_clear()
    yield tmp_path
    for cache in caches:
        cache.cache_clear()


@pytest.fixture
def trial(fresh, monkeypatch):
    """Let a shell script play the trial process."""

    def play(script: str) -> None:
        file = fresh / "python"
        file.write_text(f"#!/bin/sh\n{script}\n")
        file.chmod(file.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setattr(sys, "executable", str(file))

    return play


@pytest.fixture
def library(fresh) -> Path:
    file = fresh / "libLLVM-15.so.1"
    file.write_text("not a library")
    return file


ABORT = "echo 'LLVM ERROR: Cannot select: fmaximum' >&2; kill -ABRT $$"
GOOD = 'echo \'{"ok": true, "mean": 0.5}\''
WRONG = 'echo \'{"ok": false, "mean": 0.25}\''
# The library with 15 in its name aborts, any other works.
PICKY = f'case "$DRJIT_LIBLLVM_PATH" in *libLLVM-15*) {ABORT};; *) {GOOD};; esac'


@posix
@pytest.mark.parametrize(
    ("script", "ok", "detail"),
    [
        (ABORT, False, "the trial process died (signal 6) LLVM ERROR: Cannot select: fmaximum"),
        ("kill -SEGV $$", False, "the trial process died (signal 11)"),
        ("exit 3", False, "the trial process died (exit 3)"),
        (WRONG, False, "rendered a trial picture wrongly (0.250)"),
        (GOOD, True, "rendered a trial picture rightly"),
    ],
)
def test_however_the_trial_ends_is_a_verdict(script, ok, detail, trial, library, capfd):
    trial(script)
    verdict = backend.try_llvm(str(library))
    assert (verdict.ok, verdict.detail) == (ok, detail)
    assert capfd.readouterr() == ("", "")


def test_a_library_that_is_not_there_is_a_verdict(fresh):
    verdict = backend.try_llvm(str(fresh / "none.so"))
    assert not verdict.ok
    assert verdict.detail.startswith("cannot be read: No such file")


@posix
@pytest.mark.parametrize("script", [ABORT, GOOD])
def test_a_verdict_is_remembered_until_the_file_changes(script, trial, library):
    trial(script)
    first = backend.try_llvm(str(library))
    trial("exit 3")
    assert backend.try_llvm(str(library)) == first
    library.write_text("another library")
    assert backend.try_llvm(str(library)).detail == "the trial process died (exit 3)"


@posix
def test_a_trial_that_was_killed_from_outside_is_not_remembered(trial, library):
    """Out of memory today says nothing of tomorrow."""
    trial("kill -KILL $$")
    assert not backend.try_llvm(str(library)).ok
    trial(GOOD)
    assert backend.try_llvm(str(library)).ok


@posix
@pytest.mark.parametrize("memory", ["", "[]", "{", '{"a": 1}', "\0"])
def test_a_damaged_memory_is_no_memory(memory, trial, library, fresh):
    (fresh / "cache").mkdir()
    (fresh / "cache" / "trials.json").write_text(memory)
    trial(GOOD)
    assert backend.try_llvm(str(library)).ok


def offer(monkeypatch, *found: Candidate) -> None:
    # As in a process in which Dr.Jit has not chosen yet.
    monkeypatch.delitem(sys.modules, "drjit", raising=False)
    for module in (backend, simtip.doctor):
        monkeypatch.setattr(module, "candidates", lambda: list(found))


@pytest.fixture
def bad(library) -> Candidate:
    return Candidate(str(library), "DRJIT_LIBLLVM_PATH", "15")


@posix
def test_a_bad_library_is_passed_over_for_a_good_one(trial, fresh, bad, monkeypatch):
    good = fresh / "libLLVM-19.so.1"
    good.write_text("works")
    offer(monkeypatch, bad, Candidate(str(good), "system", "19"))
    trial(PICKY)
    chosen = backend.choose()
    assert (chosen.name, chosen.libllvm) == ("llvm", str(good))
    assert chosen.reason == "system: rendered a trial picture rightly"


@pytest.mark.usefixtures("fresh")
def test_a_tested_version_of_the_wheel_needs_no_trial(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    offer(monkeypatch, Candidate("/lib/libLLVM.so", "the wheel", "21.1.8", tested=True))
    assert backend.choose().libllvm == "/lib/libLLVM.so"


@posix
def test_without_any_good_library_it_is_scalar_and_says_why(trial, bad, monkeypatch):
    offer(monkeypatch, bad)
    trial(PICKY)
    chosen = backend.choose()
    assert (chosen.name, chosen.reason) == ("scalar", "no GPU and no LLVM library that works")
    with pytest.raises(BackendError, match="no LLVM library that works was found; see `simtip doc"):
        backend.choose("llvm")


@posix
def test_doctor_says_which_library_was_rejected_and_why(trial, bad, ask, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    offer(monkeypatch, bad)
    trial(PICKY)
    answer = ask("doctor", "--json")
    assert (answer.code, answer.err) == (0, "")
    found = json.loads(answer.out)
    assert found["llvm"] == [
        {
            "path": bad.path,
            "source": "DRJIT_LIBLLVM_PATH",
            "version": "15",
            "ok": False,
            "detail": "the trial process died (signal 6) LLVM ERROR: Cannot select: fmaximum",
        }
    ]
    assert found["backend"]["name"] == "scalar"
    assert found["advice"]
    table = ask("doctor").out
    assert "signal 6" in table
    assert "to mend: " in table


@posix
def test_doctor_ends_with_1_if_nothing_renders(trial, ask, monkeypatch):
    offer(monkeypatch)
    trial("exit 3")
    answer = ask("doctor", "--json")
    found = json.loads(answer.out)
    assert (answer.code, found["ok"]) == (1, False)
    assert found["trial"] == "the trial process died (exit 3)"


# Real libraries.

SYSTEM = sorted(Path("/usr/lib").glob("*/libLLVM-1[0-5].so.1"))
"""Too old for Dr.Jit 1.5: they load, and abort at the first kernel."""

DOUBTFUL = [*map(str, SYSTEM), "scene.yaml", "/nowhere/libLLVM.so"]


@pytest.fixture
def folder(tmp_path):
    return lay_out(tmp_path)


def asked(folder, *argv, code=CALL, library=None):
    environment = {"DRJIT_LIBLLVM_PATH": library, "SIMTIP_BACKEND": None}
    memory = str(folder / "memory")
    return in_a_process(*argv, cwd=folder, code=code, XDG_CACHE_HOME=memory, **environment)


@pytest.mark.slow
@pytest.mark.parametrize("library", DOUBTFUL, ids=lambda path: Path(path).name)
def test_run_works_whatever_library_is_named(library, folder, ran):
    done = asked(folder, "run", "scene.yaml", "--json", library=library)
    assert (done.returncode, done.stderr) == (0, "")
    result = json.loads(done.stdout)
    for key in ("status", "backend", "tip_detected_px", "tip_measured_mm"):
        assert result[key] == ran.printed[key]


@pytest.mark.slow
@pytest.mark.parametrize("library", DOUBTFUL[:-1], ids=lambda path: Path(path).name)
def test_doctor_rejects_it_with_a_reason(library, folder):
    done = asked(folder, "doctor", "--json", library=library)
    assert (done.returncode, done.stderr) == (0, "")
    first = json.loads(done.stdout)["llvm"][0]
    real = str((folder / library).resolve())
    assert (first["path"], first["source"], first["ok"]) == (real, "DRJIT_LIBLLVM_PATH", False)
    assert first["detail"].startswith("the trial process died")


ONLY = """
import simtip.render.backend as backend
from simtip.render.libllvm import Candidate
found = [Candidate(path, "system", None) for path in {paths!r}]
backend.candidates = lambda: found
backend.gpu_present = lambda: False
"""


@pytest.mark.slow
@pytest.mark.parametrize("paths", [[], list(map(str, SYSTEM))], ids=["none", "bad ones"])
def test_run_works_without_a_usable_library(paths, folder):
    done = asked(
        folder, "run", "scene.yaml", "-o", "out", "--json", code=ONLY.format(paths=paths) + CALL
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["status"] == "ok"
    manifest = json.loads((folder / "out" / "manifest.json").read_text())
    assert manifest["backend"]["variant"] == "scalar_rgb"
    assert manifest["backend"]["reason"] == "no GPU and no LLVM library that works"


# Dr.Jit imported first, with whatever it finds by itself; its own complaints go nowhere.
DRJIT_FIRST = """
import os
kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
os.dup2(nowhere, 2)
import drjit
os.dup2(kept, 2)
import simtip.render.backend as backend
backend.gpu_present = lambda: False
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "library",
    [None, *DOUBTFUL[:-1]],
    ids=lambda path: "default" if path is None else Path(path).name,
)
def test_drjit_imported_first_does_not_abort(library, folder):
    done = asked(
        folder, "run", "scene.yaml", "-o", "out", "--json", code=DRJIT_FIRST + CALL, library=library
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["status"] == "ok"
    used = json.loads((folder / "out" / "manifest.json").read_text())["backend"]
    if library is not None:
        assert used["variant"] == "scalar_rgb"
        assert used["reason"].startswith("Dr.Jit was imported before simtip")


@pytest.mark.slow
def test_llvm_asked_for_where_it_would_abort_is_one_line(folder):
    library = next(iter(DOUBTFUL))
    argv = ("run", "scene.yaml", "--backend", "llvm", "--json")
    done = asked(folder, *argv, code=DRJIT_FIRST + CALL, library=library)
    assert one_line(done.stderr).endswith("see `simtip doctor`")
    assert (done.returncode, done.stdout) == (2, "")
