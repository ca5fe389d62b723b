"""A program run once, within bounds of time and output, and nothing of it left behind."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import IO

MAX_STDOUT = 1 << 20
"""Bytes of standard output: more is a flood, and the program is stopped."""
KEPT_STDERR = 1 << 12
"""Bytes kept of standard error, the last ones."""
CHUNK = 1 << 16
GRACE_S = 2.0
"""How long to wait for pipes that a process outside of the program's group keeps open."""


LONGEST_S = math.inf
"""Of any program, whatever its own limit."""


@dataclass(frozen=True)
class Finished:
    """What a program did.

    Attributes
    ----------
    code
        Exit code, negative for a signal; None if it was stopped at its time limit.
    stdout
        At most `MAX_STDOUT` bytes.
    stderr
        The last `KEPT_STDERR` bytes.
    flooded
        It wrote more to standard output than that, and was stopped.
    """

    code: int | None
    stdout: bytes
    stderr: bytes
    flooded: bool


def run_program(arguments: Sequence[str], timeout_s: float) -> Finished:
    """Run a program without a shell, in the current folder, with no standard input.

    It gets a process group of its own, and when it ends, is stopped or we are interrupted,
    whatever is still in that group is killed.

    Parameters
    ----------
    arguments
        The program and its arguments.
    timeout_s
        Wall time until it is stopped, s.

    Raises
    ------
    OSError, ValueError
        It cannot be started.
    """
    process = subprocess.Popen(  # noqa: S603 (the user's own program, and no shell)
        list(arguments),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    try:
        out = _Reader(process, process.stdout, first=MAX_STDOUT)
        err = _Reader(process, process.stderr, last=KEPT_STDERR)
        code = _wait(process, min(timeout_s, LONGEST_S))
    finally:
        _kill_group(process)
    for reader in (out, err):
        reader.join(GRACE_S)
    return Finished(code, bytes(out.kept), bytes(err.kept), out.flooded)


def _wait(process: subprocess.Popen[bytes], timeout_s: float) -> int | None:
    try:
        return process.wait(timeout_s)
    except subprocess.TimeoutExpired:
        return None


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    if os.name == "posix":
        try:
            # Its members outlive their leader, whose number stays theirs until the last is gone.
            os.killpg(process.pid, signal.SIGKILL)
        except (ProcessLookupError, PermissionError):  # nobody is left
            return
        finally:
            process.wait()
    else:
        process.kill()
        process.wait()


class _Reader(threading.Thread):
    """Empties a pipe, so that the program never waits for us, and keeps a bounded part."""

    def __init__(
        self,
        process: subprocess.Popen[bytes],
        pipe: IO[bytes] | None,
        *,
        first: int | None = None,
        last: int | None = None,
    ) -> None:
        super().__init__(daemon=True)
        self.kept = bytearray()
        self.flooded = False
        self._process, self._pipe, self._first, self._last = process, pipe, first, last
        self.start()

    def run(self) -> None:
        """Read to the end."""
        if self._pipe is None:
            return
        with self._pipe as pipe:
            while chunk := os.read(pipe.fileno(), CHUNK):
                self._keep(chunk)

    def _keep(self, chunk: bytes) -> None:
        if self.flooded:
            return
        self.kept += chunk
        if self._last is not None:
            del self.kept[: -self._last]
        if self._first is not None and len(self.kept) > self._first:
            self.flooded = True
            del self.kept[self._first :]
            _kill_group(self._process)
