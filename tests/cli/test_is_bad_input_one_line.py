"""Whatever is wrong with the input: one line with file, field and remedy, exit code 2, no trace.

Most cases call the command line in this process; a few at the end are whole processes.
"""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from asked import Answer
from command_line import MEASURE, RIG, SCENE, in_a_process, needle_png, one_line, snapshot

from simtip.render import backend

RUN = ("run", "scene.yaml", "-o", "out", "--json")
RENDER = ("render", "scene.yaml", "-o", "out")

ALIASES = "bomb: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"{name}: &{name} [{', '.join(['*' + before] * 9)}]\n"
    for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)


@dataclass(frozen=True)
class Bad:
    """One text in a file changed, and how the complaint begins and ends.

    `place` begins the message; {line} is the line of the change. `remedy` is part of what follows.
    """

    place: str
    remedy: str
    old: str = ""
    new: str | bytes = ""
    argv: tuple[str, ...] = RUN


@pytest.fixture(autouse=True)
def no_rendering(monkeypatch):
    """Bad input is refused before the work, not after it."""

    def render(*_, **__):
        pytest.fail("rendered in vain")

    monkeypatch.setattr("simtip.simulation.render_pair", render)


def replaced(text: str, case: Bad) -> tuple[bytes, int]:
    if not case.old:
        return (case.new.encode() if isinstance(case.new, str) else case.new), 1
    assert text.count(case.old) == 1, f"{case.old!r} is not once in the file"
    line = text[: text.index(case.old)].count("\n") + 1
    return text.replace(case.old, str(case.new)).encode(), line


def check(ask, bench: Path, case: Bad, file: str, text: str) -> None:
    content, line = replaced(text, case)
    (bench / file).write_bytes(content)
    judge(ask, bench, case, line)


def judge(ask, bench: Path, case: Bad, line: int = 0) -> None:
    before = snapshot(bench)
    answer = ask(*case.argv)
    message = one_line(answer.err)
    assert message.startswith(case.place.format(line=line)), message
    remedy = message.partition("; ")[2]
    assert remedy, message
    assert case.remedy in remedy, message
    assert answer.code == 2
    assert answer.out == ""
    assert snapshot(bench) == before


SCENES = {
    "negative exposure": Bad(
        "scene.yaml:{line}: sensor.exposure_s: ", "correct", "s: 0.04", "s: -0.04"
    ),
    "unknown key": Bad(
        "scene.yaml:{line}: sensor.expozure_s: unknown key",
        "did you mean 'exposure_s'?",
        "exposure_s",
        "expozure_s",
    ),
    "unknown key in a row": Bad(
        "scene.yaml:{line}: rig.right.rio: unknown key",
        "did you mean 'roi'?",
        "roi: [990",
        "rio: [990",
    ),
    "duplicate key": Bad("scene.yaml:{line}: ", "keep one", "seed: 3", "name: again"),
    "NaN intrinsics": Bad("scene.yaml:{line}: rig.left.fx: ", "number", "1909.84", ".nan"),
    "infinite intrinsics": Bad("scene.yaml:{line}: rig.right.cy: ", "number", "729.04", "-.inf"),
    "singular intrinsics": Bad("scene.yaml:{line}: rig.right.fy: ", "correct", "1914.32", "0"),
    "text for a number": Bad(
        "scene.yaml:{line}: rig.left.fx: ", "without quotes", "1909.84", '"1909.84"'
    ),
    "a mirror for a rotation": Bad(
        "scene.yaml:8: rig.R: not a rotation", "correct", "[0.036, 0.999", "[-0.036, -0.999"
    ),
    "a shear for a rotation": Bad("scene.yaml:8: rig.R: not a rotation", "", "0.036", "0.5"),
    "no baseline": Bad(
        "scene.yaml:{line}: rig.t_mm: ", "correct", "[72.047, 2.138, 14.041]", "[0, 0, 0]"
    ),
    "region off the sensor": Bad("scene.yaml:5: rig.left.roi: ", "correct", "[780,", "[2000,"),
    "needle outside both views": Bad(
        "scene.yaml:{line}: needle.tip_mm: the needle is outside both images",
        "into a camera's field of view",
        "[-10, 20, 170]",
        "[-10, -400, 170]",
    ),
    "tip behind the left camera": Bad(
        "scene.yaml:{line}: needle.tip_mm: the tip is behind the left camera",
        "above 0",
        "[-10, 20, 170]",
        "[-10, 20, -170]",
    ),
    "tip behind the right camera": Bad(
        "scene.yaml:{line}: needle.tip_mm: the tip is behind the right camera",
        "above 0",
        "[-10, 20, 170]",
        "[500, 20, 170]",
    ),
    "needle in the background": Bad(
        "scene.yaml:{line}: needle.tip_mm: ", "background.centre_mm", ", 20, 170]", ", 20, 300]"
    ),
    "axis without a length": Bad("scene.yaml:{line}: needle.axis: ", "", "[0, -1, 0]", "[0, 0, 0]"),
    "cone longer than the needle": Bad(
        "scene.yaml:13: needle: ", "", "length_mm: 5", "length_mm: 500"
    ),
    "unknown kind of tip": Bad("scene.yaml:{line}: needle.tip.kind: ", "choose", "cone", "pyramid"),
    "no light": Bad(
        "scene.yaml:1: lamps: there is no light",
        "give lamps",
        SCENE[SCENE.index("lamps") : SCENE.index("sensor")],
        "",
    ),
    "unknown detector": Bad(
        "scene.yaml:{line}: detect.name: ", "did you mean 'lin2020'?", "lin2020", "lin2002"
    ),
    "unknown detector parameter": Bad(
        "scene.yaml:{line}: detect.min_aera_px: ", "'min_area_px'", "min_area_px", "min_aera_px"
    ),
    "bad detector value": Bad(
        "scene.yaml:{line}: detect.min_area_px: ", "at least 0", "px: 200", "px: -200"
    ),
    "not YAML": Bad("scene.yaml:", "correct", "seed: 3", "seed: [3"),
    "not UTF-8": Bad("scene.yaml:1: is not UTF-8", "save it as UTF-8", "", b"name: caf\xe9\n"),
    "binary": Bad("scene.yaml:1: is not UTF-8", "save it as UTF-8", "", needle_png()),
    "empty": Bad("scene.yaml: is empty", "written to the end?"),
    "a list": Bad("scene.yaml:1: a scene is a mapping", "scenes/", "", "- 1\n"),
    "a control character": Bad("scene.yaml:1: a: holds the control", "remove", "", 'a: "\\e[2J"\n'),
    "aliases that explode": Bad("scene.yaml:", "fewer", "", ALIASES),
    "a Python object": Bad(
        "scene.yaml:1: the tag !!python/object/apply:os.system",
        "plain values only",
        "",
        '!!python/object/apply:os.system ["touch hacked"]\n',
    ),
    "a Python name in a value": Bad(
        "scene.yaml:{line}: ", "plain values only", "name: bench", "name: !!python/name:os.system"
    ),
    "rendered, too": Bad(
        "scene.yaml:{line}: needle.tip_mm: ", "above 0", "0, 170]", "0, -170]", argv=RENDER
    ),
    "its rig exported, too": Bad(
        "scene.yaml:{line}: rig.left.fx: ",
        "number",
        "1909.84",
        ".nan",
        argv=("rig", "scene.yaml", "-o", "out.yaml"),
    ),
}


@pytest.mark.parametrize("case", SCENES.values(), ids=SCENES)
def test_a_bad_scene_is_one_line(case, ask, bench):
    check(ask, bench, case, "scene.yaml", SCENE)


ROTATION = RIG[RIG.index("[ 0.8616") : RIG.index("T:")]
RIGS = {
    "NaN": Bad("rig.yaml:{line}: M1.data[0]: is nan", "", "1909.84", ".nan", MEASURE),
    "singular": Bad("rig.yaml:5: M1: is singular", "above 0", "1909.84", "0.", MEASURE),
    "skewed": Bad("rig.yaml:15: M2: has skew", "without", "1923.38, 0.", "1923.38, 2.", MEASURE),
    "a mirror": Bad(
        "rig.yaml:25: R: is not a rotation",
        "cv2.stereoCalibrate",
        ROTATION,
        "[1., 0., 0., 0., 1., 0., 0., 0., -1. ]\n",
        MEASURE,
    ),
    "no rotation": Bad(
        "rig.yaml:25: R: is not a rotation",
        "cv2.stereoCalibrate",
        ROTATION,
        "[1., 0.5, 0., 0., 1., 0., 0., 0., 1. ]\n",
        MEASURE,
    ),
    "no baseline": Bad(
        "rig.yaml:32: T: makes a baseline of 0 mm",
        "",
        "-69.26618548172685, -0.17853838078229262, 24.385540938383933",
        "0., 0., 0.",
        MEASURE,
    ),
    "too few numbers": Bad(
        "rig.yaml:36: T.data: has 2", "correct", "-69.26618548172685, ", "", MEASURE
    ),
    "a node missing": Bad("rig.yaml: M2: ", "add M2", "M2", "N2", MEASURE),
    "an odd distortion": Bad(
        "rig.yaml:10: D1: ",
        "4, 5, 8",
        "cols: 5\n   dt: d\n   data: [ 0., 0., 0., 0., 0. ]\nM2",
        "cols: 3\n   dt: d\n   data: [ 0., 0., 0. ]\nM2",
        MEASURE,
    ),
    "another size": Bad(
        "left.png: the left image is 80x100 px, but the rig's left camera 640x100",
        "give the rig that took the images, not rig.yaml",
        "image_width: 80",
        "image_width: 640",
        MEASURE,
    ),
    "a Python object": Bad(
        "rig.yaml:{line}: ", "", "image_width: 80", "image_width: !!python/name:os.system", MEASURE
    ),
    "aliases that explode": Bad("rig.yaml:", "fewer", "", ALIASES, MEASURE),
    "no YAML": Bad("rig.yaml:1: is not UTF-8", "UTF-8", "", needle_png(), MEASURE),
    "empty": Bad("rig.yaml: is empty", "written to the end?", "", "", MEASURE),
}


@pytest.mark.parametrize("case", RIGS.values(), ids=RIGS)
def test_a_bad_rig_is_one_line(case, ask, bench):
    check(ask, bench, case, "rig.yaml", RIG)


PNG = needle_png()
HUGE = PNG[:16] + struct.pack(">II", 2**31 - 1, 2**31 - 1) + PNG[24:]
IMAGES = {
    "empty": Bad("left.png: is empty", "written to the end?", new=b""),
    "truncated": Bad("left.png: is cut short", "again", new=PNG[: len(PNG) // 2]),
    "one byte short": Bad("left.png: is cut short", "again", new=PNG[:-1]),
    "damaged": Bad("left.png: is a damaged PNG", "again", new=PNG[:60] + b"\0\0" + PNG[62:]),
    "with an absurd size": Bad("left.png: ", "again", new=HUGE),
    "no image": Bad("left.png: is not a PNG, TIFF, JPEG or BMP", "as PNG", new=b"hello"),
    "of another size": Bad(
        "left.png: the left image is 81x100 px, but the rig's left camera 80x100",
        "not rig.yaml",
        new=needle_png((81, 100)),
    ),
}


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("case", IMAGES.values(), ids=IMAGES)
def test_a_bad_image_is_one_line(case, side, ask, bench):
    place = case.place.replace("left", side)
    check(ask, bench, Bad(place, case.remedy, "", case.new, MEASURE), f"{side}.png", "")


def with_option(*more: str, base: tuple[str, ...] = MEASURE) -> tuple[str, ...]:
    return (*base, *more)


def at(index: int, value: str, base: tuple[str, ...] = MEASURE) -> tuple[str, ...]:
    return (*base[:index], value, *base[index + 1 :])


ARGUMENTS = {
    "no scene": Bad("none.yaml: no such file", "check the path", argv=("run", "none.yaml")),
    "no rig": Bad("none.yaml: no such file", "check the path", argv=at(2, "none.yaml")),
    "no left image": Bad("none.png: no such file", "check the path", argv=at(3, "none.png")),
    "no right image": Bad("none.png: no such file", "check the path", argv=at(4, "none.png")),
    "folder for a scene": Bad("folder: is a folder", "name a file", argv=("run", "folder")),
    "folder for a rig": Bad("folder: is a folder", "or a file", argv=at(2, "folder")),
    "folder for an image": Bad("folder: is a folder", "name a file", argv=at(3, "folder")),
    "pipe for a scene": Bad("pipe: is not a regular file", "disk", argv=("run", "pipe")),
    "codes in a name": Bad(r"\x1b[2J.yaml: no such file", "", argv=("run", "\x1b[2J.yaml")),
    "unknown detector": Bad(
        "--detector: there is no detector 'lin2002'",
        "did you mean 'lin2020'?",
        argv=with_option("--detector", "lin2002"),
    ),
    "unknown parameter": Bad(
        "--set thresold: ", "did you mean 'threshold'?", argv=with_option("--set", "thresold=1")
    ),
    "no number": Bad(
        "--set threshold: 'high' is not", "give int", argv=with_option("--set", "threshold=high")
    ),
    "number out of range": Bad(
        "--set threshold: 256 ", "at most 255", argv=with_option("--set", "threshold=256")
    ),
    "setting that does not suit the image": Bad(
        "--set full_scale: for the left image: the image has 8 bits",
        "leave full_scale out",
        argv=with_option("--set", "full_scale=4095"),
    ),
    "no value": Bad(
        "--set: 'threshold' is not", "threshold=105", argv=with_option("--set", "threshold")
    ),
    "no key": Bad("--set: ' =3' is not", "threshold=105", argv=with_option("--set", " =3")),
    "no distance": Bad("--max-distance: ", "above 0", argv=with_option("--max-distance", "nan")),
    "unknown method": Bad(
        "Invalid value for '--method': 'svdd' is not one of 'svd'",
        "`simtip measure --help`",
        argv=with_option("--method", "svdd"),
    ),
    "unknown back end": Bad(
        "--backend: there is no back end 'gpu'",
        "cuda",
        argv=with_option("--backend", "gpu", base=RUN),
    ),
    "unknown back end for doctor": Bad(
        "--backend: there is no back end 'gpu'", "cuda", argv=("doctor", "--backend", "gpu")
    ),
    "negative seed": Bad(
        "Invalid value for '--seed': ", "", argv=with_option("--seed", "-1", base=RUN)
    ),
    "huge seed": Bad(
        "Invalid value for '--seed': ", "", argv=with_option("--seed", str(2**63), base=RUN)
    ),
    "seed in words": Bad(
        "Invalid value for '--seed': ", "", argv=with_option("--seed", "x", base=RUN)
    ),
    "unknown command": Bad(
        "No such command 'rn'. Did you mean 'run'", "`simtip --help`", argv=("rn",)
    ),
    "unknown option": Bad(
        "No such option: --jsn", "`simtip run --help`", argv=("run", "--jsn", "x")
    ),
    "scene not given": Bad("Missing argument 'SCENE'", "`simtip run --help`", argv=("run",)),
    "rig not given": Bad(
        "Missing option '--rig'",
        "`simtip measure --help`",
        argv=("measure", "left.png", "right.png"),
    ),
    "right image not given": Bad("Missing argument 'RIGHT'", "--help`", argv=MEASURE[:4]),
    "folder not given": Bad(
        "Missing option '-o' / '--out'", "--help`", argv=("render", "scene.yaml")
    ),
    "option without value": Bad(
        "Option '-o' requires", "--help`", argv=("run", "scene.yaml", "-o")
    ),
    "too many": Bad("Got unexpected extra argument", "--help`", argv=("schema", "scene.yaml")),
    "output not empty": Bad("full: exists and is not empty", "another", argv=at(3, "full", RUN)),
    "output not empty, rendering": Bad(
        "full: exists and is not empty", "another", argv=at(3, "full", RENDER)
    ),
    "output is the working folder": Bad(".: exists and is not", "another", argv=at(3, ".", RUN)),
    "output is a file": Bad(
        "full/keep: exists and is not a folder", "", argv=at(3, "full/keep", RUN)
    ),
    "output under a file": Bad(
        "full/keep/out: cannot be written", "another", argv=at(3, "full/keep/out", RUN)
    ),
    "output with too long a name": Bad("x" * 300, "another", argv=at(3, "x" * 300, RUN)),
    "rig file exists": Bad(
        "scene.yaml: exists", "", argv=("rig", "scene.yaml", "-o", "scene.yaml")
    ),
    "rig file is a folder": Bad(
        "full: ", "name the format", argv=("rig", "scene.yaml", "-o", "full")
    ),
    "rig file nowhere": Bad(
        "nowhere/rig.yaml: its folder",
        "make the folder",
        argv=("rig", "scene.yaml", "-o", "nowhere/rig.yaml"),
    ),
}


@pytest.mark.parametrize("case", ARGUMENTS.values(), ids=ARGUMENTS)
def test_bad_arguments_are_one_line(case, ask, bench):
    (bench / "folder").mkdir()
    (bench / "full").mkdir()
    (bench / "full" / "keep").write_text("keep me")
    os.mkfifo(bench / "pipe")
    judge(ask, bench, case)


def test_an_unknown_back_end_in_the_environment_is_not_blamed_on_the_scene(ask, bench, monkeypatch):
    monkeypatch.setenv("SIMTIP_BACKEND", "gpu")
    judge(ask, bench, Bad("SIMTIP_BACKEND: there is no back end 'gpu'", "cuda"))


def test_no_gpu_for_cuda_is_one_line(ask, bench, monkeypatch):
    monkeypatch.setattr(backend, "gpu_present", lambda: False)
    backend.try_cuda.cache_clear()
    monkeypatch.setenv("SIMTIP_BACKEND", "cuda")
    judge(ask, bench, Bad("CUDA does not work here: no NVIDIA driver", "`simtip doctor`"))
    backend.try_cuda.cache_clear()


def test_no_arguments_is_the_help(ask):
    answer = ask()
    assert answer.code == 2
    assert answer.err == ""
    for command in ("run", "render", "measure", "rig", "doctor", "schema"):
        assert f" {command} " in answer.out


PROCESSES = {
    "scene": (SCENES["unknown key"], "scene.yaml", SCENE),
    "hostile scene": (SCENES["a Python object"], "scene.yaml", SCENE),
    "rig": (RIGS["a mirror"], "rig.yaml", RIG),
    "image": (IMAGES["truncated"], "left.png", ""),
}


@pytest.mark.slow
@pytest.mark.parametrize(("case", "file", "text"), PROCESSES.values(), ids=PROCESSES)
def test_a_whole_process_says_the_same(case, file, text, bench):
    def whole(*arguments):
        done = in_a_process(*arguments, cwd=bench)
        return Answer(done.returncode, done.stdout, done.stderr)

    argv = MEASURE if file != "scene.yaml" else case.argv
    check(whole, bench, replace(case, argv=argv), file, text)


EMPTY = {
    "run": ("run", "scene.yaml", "-o", ""),
    "render": ("render", "scene.yaml", "-o", ""),
    "sweep": ("sweep", "scene.yaml", "-o", ""),
    "a cache": ("sweep", "scene.yaml", "-o", "out", "--cache", ""),
    "results": ("results", ""),
    "cache": ("cache", "--cache", ""),
    "images": ("detect", "left.png", ""),
    "a scene": ("run", ""),
}


@pytest.mark.parametrize("argv", EMPTY.values(), ids=EMPTY)
def test_an_empty_name_is_not_the_working_folder(argv, bench, ask):
    before = snapshot(bench)
    answer = ask(*argv)
    assert ": is empty; see `simtip " in one_line(answer.err)
    assert answer.code == 2
    assert snapshot(bench) == before
