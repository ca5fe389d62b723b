"""A full disk, a closed or full standard output: one line, exit code 2, nothing half-written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from command_line import MEASURE, in_a_process, one_line, snapshot

from simtip.errors import InputError
from simtip.output_folder import result_folder

CALL = "from simtip.cli import main; main()"
# SIGXFSZ is ignored by Python, so a write beyond the limit fails as on a full disk.
FULL_DISK = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (%d, %d)); {CALL}"
posix = pytest.mark.skipif(os.name != "posix", reason="file size limits and descriptors")


def write_image(folder: Path) -> None:
    (folder / "right.png").write_bytes(b"a picture")
    raise InputError("cannot be written (No space left)", file=folder / "left.png", remedy="x")


def write_text(folder: Path) -> None:
    raise OSError(28, "No space left on device", str(folder / "truth.json"))


@pytest.mark.parametrize(
    ("write", "place"), [(write_image, "out/left.png: "), (write_text, "out: ")]
)
def test_a_failed_write_names_the_folder_that_was_asked_for(write, place, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as caught, result_folder("out") as folder:
        write(folder)
    assert str(caught.value).startswith(f"{place}cannot be written (No space left")
    assert "name another output folder" in str(caught.value)
    assert snapshot(tmp_path) == {}


def test_an_error_about_another_file_keeps_its_name(tmp_path):
    with (
        pytest.raises(InputError, match=r"^scene.yaml: no; mend it$"),
        result_folder(tmp_path / "o"),
    ):
        raise InputError("no", file="scene.yaml", remedy="mend it")


@posix
@pytest.mark.slow
@pytest.mark.parametrize(
    ("limit", "place"),
    [(1000, "out/left.png: cannot be written"), (20000, "out: cannot be written")],
)
def test_a_full_disk_leaves_nothing(limit, place, bench):
    before = snapshot(bench)
    done = in_a_process(
        "render", "scene.yaml", "--exr", "-o", "out", cwd=bench, code=FULL_DISK % (limit, limit)
    )
    message = one_line(done.stderr)
    assert message.startswith(place)
    assert ".simtip-" not in message
    assert (done.returncode, done.stdout) == (2, "")
    assert snapshot(bench) == before


ENDINGS = {
    "full": "import os; os.dup2(os.open('/dev/full', os.O_WRONLY), 1)",
    "closed": "import sys; sys.stdout = None",
}


@posix
@pytest.mark.slow
@pytest.mark.parametrize("ending", ENDINGS.values(), ids=ENDINGS)
@pytest.mark.parametrize("argv", [("--version",), (*MEASURE, "--json"), MEASURE], ids=" ".join)
def test_output_that_goes_nowhere_is_one_line(argv, ending, bench):
    if "full" in ending and not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    done = in_a_process(*argv, cwd=bench, code=f"{ending}; {CALL}")
    assert one_line(done.stderr).startswith("standard output: ")
    assert done.returncode == 2
