"""Is a program stopped in time, with all that it started, and without filling the memory?"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from programs import GRAY, TIP, program

from simtip import detect

pytestmark = pytest.mark.skipif(os.name != "posix", reason="process groups")

# A grandchild that outlives its parent, and says where it is.
GRANDCHILD = """
child = os.fork()
if child == 0:
    {before}
    time.sleep(60)
    os._exit(0)
with open({file!r}, "w") as file:
    file.write(str(child))
"""


def grandchild(folder: Path, before: str = "pass") -> tuple[str, Path]:
    file = folder / "grandchild"
    return GRANDCHILD.format(file=str(file), before=before), file


def is_gone(pid: int) -> bool:
    """Say whether a process has ended; one that waits for init to notice has."""
    for _ in range(100):
        try:
            if Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                return True
            os.kill(pid, 0)
        except (ProcessLookupError, FileNotFoundError):
            return True
        time.sleep(0.02)
    return False


def test_at_its_time_limit_it_is_killed_with_its_grandchildren(tmp_path):
    body, file = grandchild(tmp_path)
    stubborn = "signal.signal(signal.SIGTERM, signal.SIG_IGN); print('slow', file=sys.stderr)"
    reference = program(tmp_path, f"{body}\n{stubborn}\nsys.stderr.flush()\ntime.sleep(60)")
    start = time.monotonic()
    o = detect.configure(reference, {"timeout_s": 0.4})(GRAY)
    assert time.monotonic() - start < 5
    assert o.status == "command_timed_out"
    assert "after 0.4 s" in o.reason
    assert "slow" in o.reason
    assert is_gone(int(file.read_text()))


def test_a_grandchild_that_keeps_the_pipe_open_delays_nothing(tmp_path):
    body, file = grandchild(tmp_path)
    start = time.monotonic()
    o = detect.configure(program(tmp_path, f"{body}\nprint({TIP!r})"))(GRAY)
    assert time.monotonic() - start < 5
    assert o.tip_px.tolist() == [3.25, 4.5]
    assert is_gone(int(file.read_text()))


def test_a_flood_is_stopped(tmp_path):
    body = "while True: os.write(1, b'[1, ' * 10000)"
    start = time.monotonic()
    o = detect.configure(program(tmp_path, body))(GRAY)
    assert time.monotonic() - start < 10
    assert o.status == "invalid_output"
    assert "more than 1048576 bytes" in o.reason


def test_a_flood_of_complaints_hinders_nothing(tmp_path):
    body = f"for _ in range(1000): os.write(2, b'warning ' * 1000)\nprint({TIP!r})"
    assert detect.configure(program(tmp_path, body))(GRAY).ok


def test_it_has_no_standard_input_to_wait_for(tmp_path):
    body = f"assert sys.stdin.read() == ''\nprint({TIP!r})"
    assert detect.configure(program(tmp_path, body), {"timeout_s": 5})(GRAY).ok


@pytest.mark.parametrize("body", [f"print({TIP!r})", "sys.exit(1)", "time.sleep(9)"])
def test_no_image_file_stays(body, tmp_path, monkeypatch):
    temporary = tmp_path / "te mp"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    detect.configure(program(tmp_path, body), {"timeout_s": 0.3})(GRAY)
    assert list(temporary.iterdir()) == []


@pytest.mark.slow
def test_an_interrupt_takes_the_program_along(tmp_path):
    file = tmp_path / "pid"
    body = f"open({str(file)!r}, 'w').write(str(os.getpid()))\ntime.sleep(60)"
    code = (
        "import sys, numpy as np\nfrom simtip import detect\n"
        "detect.configure(sys.argv[1])(np.zeros((4, 4), np.uint8))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, program(tmp_path, body)], stderr=subprocess.PIPE
    )
    while not (file.exists() and file.read_text()):
        time.sleep(0.02)
        assert process.poll() is None
    process.send_signal(2)
    assert b"KeyboardInterrupt" in process.communicate(timeout=20)[1]
    assert is_gone(int(file.read_text()))
