from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time

import pytest
from command_line import SCENE, one_line, snapshot

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="sends SIGINT"),
]

# Says when the first part of the picture is done, then renders on.
CALL = """
import simtip.console
from contextlib import contextmanager

@contextmanager
def telling(title):
    yield lambda done: print("rendering", flush=True)

simtip.console.progress_bar = telling
from simtip.cli import main
main()
"""


@pytest.mark.parametrize("backend", ["scalar", "auto"])
def test_ctrl_c_while_rendering(backend, tmp_path):
    # Enough samples for a minute, so that the interrupt comes in the middle.
    scene = re.sub(r"samples: \d+", "samples: 16384", SCENE)
    (tmp_path / "scene.yaml").write_text(scene)
    before = snapshot(tmp_path)
    process = subprocess.Popen(
        [sys.executable, "-c", CALL, "run", "scene.yaml", "-o", "out"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "SIMTIP_BACKEND": backend},
    )
    assert process.stdout.readline() == "rendering\n"
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=120)
    assert one_line(stderr) == "interrupted; nothing was written"
    assert process.returncode == 130
    assert snapshot(tmp_path) == before
