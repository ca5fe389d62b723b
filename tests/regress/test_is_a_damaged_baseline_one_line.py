"""Is whatever is wrong with a baseline said in one line that names the file, with exit code 2?"""

from __future__ import annotations

import json

import numpy as np
import pytest
from made_up_baselines import baseline

from simtip.errors import InputError
from simtip.regress.baseline import SuiteReference
from simtip.regress.baseline_file import read_baseline, write_baseline
from simtip.yaml_file import load_yaml


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "base.yaml"
    write_baseline(path, baseline())
    return path


def refusal(path) -> str:
    with pytest.raises(InputError) as caught:
        read_baseline(path)
    said = str(caught.value)
    assert str(path) in said
    assert "\n" not in said
    assert caught.value.remedy
    return said


def edited(path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_what_was_written_is_what_is_read(file):
    assert read_baseline(file) == baseline()


def test_json_serves_as_well(tmp_path):
    path = tmp_path / "base.json"
    write_baseline(path, baseline())
    assert json.loads(path.read_text())["format"] == "simtip baseline"
    assert read_baseline(path) == baseline()


def test_the_same_content_is_the_same_bytes(file, tmp_path):
    again = tmp_path / "again.yaml"
    write_baseline(again, read_baseline(file))
    assert again.read_bytes() == file.read_bytes()
    assert file.read_text().endswith("\n")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("version: 1", "version: 2", "version 2"),
        ("format: simtip baseline", "format: something", "is no baseline"),
        ("images: aa", "images: ab", "was edited"),
        ("images: aa", "images: zz", "images"),
        ("u: [0.5", "u: [0.6", "was edited"),
        ("u: [0.5", "u: [half", "u[0]"),
        ("u: [0.5", "u: [.nan", "number"),
        ("u: [0.5, ", "u: [", "errors of"),
        ("u: [0.5", "u: [null", "without a v"),
        ("found: '11", "found: '10", "was edited"),
        ("found: '11", "found: '1x", "found"),
        ("case: nominal", "case: other", "was edited"),
        ("bias_px: 0.02", "bias_px: 5.0", "was edited"),
        ("bias_px: 0.02", "bias_px: -1.0", "bias_px"),
        ("noise_seed: 1", "noise_seed: 2", "was edited"),
        ("noise_seed: 1", "noise_sead: 1", "noise_sead"),
        ("noise_seed: 1", "noise_seed: true", "noise_seed"),
        ("checksum: ", "checksum: '' #", "was edited"),
        ("checksum: ", "check: ", "cut short"),
        ("axis: [0.0, -1.0]", "axis: [0.0, -0.5]", "no direction of length 1"),
        ("axis: [0.0, -1.0]", "axis: [0.0, 0.0]", "no direction of length 1"),
        ("axis: [0.0, -1.0]", "axis: [1.0e+308, -1.0]", "axis[0]"),
        ("bias: [8.0", "bias: [1.0e+308", "bias[0]"),
        ("accepted: []", "accepted: [{}]", "accepted"),
        ("suite: {", "suite: !!python/object:os.system {", "tag"),
    ],
)
def test_an_edit_is_found_and_named(file, old, new, said):
    edited(file, old, new)
    assert said in refusal(file)


def test_a_file_cut_short_anywhere_is_refused(file):
    whole = file.read_bytes()
    for share in np.linspace(0, 1, 41)[:-1]:
        file.write_bytes(whole[: int(share * (len(whole) - 2))])
        refusal(file)


def test_bytes_that_change_anywhere_are_found(file):
    """What a byte in a number, a name or a key becomes is never taken for the baseline."""
    whole = file.read_bytes()
    rng = np.random.default_rng(1)
    for place in rng.integers(0, len(whole), 150):
        byte = whole[place]
        if chr(byte) in " \n'":  # layout alone
            continue
        other = byte ^ 1
        file.write_bytes(whole[:place] + bytes([other]) + whole[place + 1 :])
        refusal(file)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\0\1\2",
        b"\xff\xfe",
        b"[1, 2",
        b"- 1\n- 2\n",
        b"just text",
        b"a: &a [*a]\n",
        b"a: &a [x, x]\nb: &b [*a, *a, *a, *a, *a, *a, *a, *a, *a]\n" * 1,
        b"[" * 5000,
        b"{format: simtip baseline}",
        b"{format: simtip baseline, version: 1, checksum: x}",
        b"{format: simtip baseline, version: 1.0, checksum: x}",
        b"x" * (5 << 20),
    ],
)
def test_what_is_no_baseline_at_all_is_refused(tmp_path, content):
    path = tmp_path / "base.yaml"
    path.write_bytes(content)
    refusal(path)


def test_aliases_that_grow_are_refused(tmp_path):
    path = tmp_path / "base.yaml"
    lines = ["format: simtip baseline", "version: 1", "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 9)]
    path.write_text("\n".join(lines))
    assert "values" in refusal(path)


def test_a_folder_and_a_missing_file_are_refused(tmp_path):
    assert "is a folder" in refusal(tmp_path)
    assert "no such file" in refusal(tmp_path / "none.yaml")


def test_a_scene_is_no_baseline(scene_path):
    assert "is no baseline" in refusal(scene_path)


def test_more_than_can_be_reviewed_is_not_written(tmp_path):
    with pytest.raises(InputError, match="fewer repeats"):
        write_baseline(tmp_path / "base.yaml", baseline(trials=10_000, conditions=2))
    assert not (tmp_path / "base.yaml").exists()


def test_the_command_line_says_it_in_one_line(ask, file):
    edited(file, "images: aa", "images: ab")
    done = ask("regress", "check", str(file))
    assert done.code == 2
    assert done.out == ""
    assert done.err.count("\n") == 1
    assert str(file) in done.err
    done = ask("regress", "update", str(file), "--all", "--reason", "because")
    assert done.code == 2


def test_a_baseline_whose_suite_is_gone_says_so(ask, file):
    done = ask("regress", "check", str(file))
    assert done.code == 2
    assert "suite.yaml" in done.err
    assert "Traceback" not in done.err


def test_a_suite_of_too_long_a_name_is_none(ask, tmp_path):
    reference = SuiteReference(name="x", file="x" * 400, sha256="b" * 64)
    file = tmp_path / "base.yaml"
    write_baseline(file, baseline().model_copy(update={"suite": reference}))
    done = ask("regress", "check", str(file))
    assert done.code == 2
    assert "names the suite xxx" in done.err
    assert done.err.count("\n") == 1


def test_the_file_is_read_with_its_limits(file):
    assert isinstance(load_yaml(file, 4 << 20).value, dict)
