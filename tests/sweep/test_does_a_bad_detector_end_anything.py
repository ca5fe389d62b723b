"""Does a detector that crashes the process or never ends cost more than its own trials?"""

import json
import os
import subprocess
import sys

import pytest
from small_sweeps import command, rows, run, summary, summary_as_users_do, sweep_file

DETECTOR = """
import os, signal, time
from simtip.detect import configure

def find(image, threshold: int = 105, min_area_px: int = 300):
    if threshold == 80:
        os.kill(os.getpid(), signal.SIGSEGV)
    if threshold == 100:
        time.sleep(1000)
    if threshold == 110:
        os._exit(3)
    if threshold == 115:
        raise SystemExit(1)
    return configure("lin2020", {"threshold": threshold, "min_area_px": min_area_px})(image)
"""


@pytest.mark.slow
def test_each_becomes_a_row_with_its_reason(tmp_path, monkeypatch):
    (tmp_path / "bad_detector.py").write_text(DETECTOR)
    paths = [str(tmp_path), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(path for path in paths if path))
    factors = {"sensor.exposure_s": [0.045, 0.05], "detect.threshold": [60, 80, 100, 110, 115, 120]}
    file = sweep_file(tmp_path, factors=factors)
    options = ("--workers", 2, "--detector", "bad_detector:find", "--time-limit", 3)
    said = summary_as_users_do(file, tmp_path / "out", *options)
    assert said["crashes"] == 6  # of three thresholds at two exposures: nothing was tried twice
    found = rows(tmp_path / "out")
    by_threshold = found.groupby("detect.threshold").status.unique().map(list).to_dict()
    assert by_threshold == {
        60: ["ok"],
        80: ["worker_died"],
        100: ["timed_out"],
        110: ["worker_died"],
        115: ["left_detector_error"],
        120: ["ok"],
    }
    reasons = found.groupby("detect.threshold").reason.first()
    assert "its process died (SIGSEGV)" in reasons[80]
    assert "longer than 3 s" in reasons[100]
    assert "exit code 3" in reasons[110]


@pytest.mark.slow
def test_code_in_a_sweep_file_is_not_run(tmp_path):
    file = sweep_file(tmp_path, detectors=["os:system"])
    said = run(file, tmp_path / "out", code=2)
    assert "may not start a program or import a module by itself" in said


HOSTILE = """
import pathlib

class Panic(BaseException):
    pass

def changes_the_image(image):
    image.setflags(write=True)
    image[...] = 0
    return (50.0, 60.0)

def panics(image):
    raise Panic("not an Exception")

def interrupts(image):
    raise KeyboardInterrupt

def prints(image):
    print("GARBAGE")
    return (50.0, 60.0)

def reads(image):
    return (float(pathlib.Path("answer.txt").read_text()), 60.0)
"""


@pytest.fixture
def hostile(tmp_path, monkeypatch):
    (tmp_path / "hostile.py").write_text(HOSTILE)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "hostile", raising=False)
    monkeypatch.chdir(tmp_path)
    return sweep_file(tmp_path, factors={})


@pytest.mark.slow
def test_none_changes_what_the_others_see(hostile, tmp_path):
    options = ("--detector", "hostile:changes_the_image", "--detector", "lin2020")
    summary(hostile, tmp_path / "out", *options)
    found = rows(tmp_path / "out").set_index("detector")
    assert found.status["lin2020"] == "ok"
    assert "detector_error" in found.status["hostile:changes_the_image"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "status"), [("panics", "left_detector_error"), ("interrupts", "error")]
)
def test_what_is_no_exception_is_a_row_too(hostile, tmp_path, name, status):
    summary(hostile, tmp_path / "out", "--detector", f"hostile:{name}")
    assert rows(tmp_path / "out").status[0] == status


@pytest.mark.slow
def test_what_one_prints_is_no_result(hostile, tmp_path):
    done = subprocess.run(
        command(hostile, tmp_path / "out", "--json", "--detector", "hostile:prints"),
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout)["done"] == 1
    assert "GARBAGE" in done.stderr


@pytest.mark.slow
def test_one_that_reads_a_file_is_asked_again(hostile, tmp_path):
    (tmp_path / "answer.txt").write_text("50")
    options = ("--detector", "hostile:reads")
    summary(hostile, tmp_path / "out", *options)
    (tmp_path / "answer.txt").write_text("40")
    summary(hostile, tmp_path / "again", *options)
    one, other = (rows(tmp_path / name) for name in ("out", "again"))
    assert one.left_error_u_px[0] - other.left_error_u_px[0] == pytest.approx(10)
