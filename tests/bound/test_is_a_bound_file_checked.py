"""`run --bound`: whatever is wrong with the file is one line, with exit code 2 and no trace."""

from __future__ import annotations

import json

import pytest
from bound_scenes import changed

from simtip.bound_file import KEYS, read_bound
from simtip.errors import InputError


def edited(data: dict, path: str, value: object) -> dict:
    """Set the value at a dotted path, or take it away with `...`."""
    *parents, last = path.split(".")
    here = data
    for key in parents:
        here = here[key]
    if value is ...:
        del here[last]
    else:
        here[last] = value
    return data


WRONG = [
    ("bound_mm", ..., "is missing"),
    ("inputs_sha256", ..., "is missing"),
    ("convergence", ..., "is missing"),
    ("bound_mm.norm", ..., "is missing"),
    ("detector", "lin2020", "unknown key"),
    ("bound_mm.w", 1.0, "unknown key"),
    ("inputs_sha256.boards", "0" * 64, "unknown key"),
    ("bound_mm", [1, 2, 3], "has to be a mapping"),
    ("bound_mm.x", "0.1", "has to be a number above 0"),
    ("bound_mm.y", True, "has to be a number above 0"),
    ("bound_mm.z", 0.0, "has to be a number above 0"),
    ("bound_mm.norm", -0.02, "has to be a number above 0"),
    ("bound_mm.norm", 0.03, "has to be the norm"),
    ("bound_mm.norm", None, "has to be the norm"),
    ("bound_mm.x", None, "has to be the norm"),
    ("inputs_sha256.rig", 7, "is no SHA-256"),
    ("inputs_sha256.rig", "0" * 63, "is no SHA-256"),
]


@pytest.mark.parametrize(("path", "value", "problem"), WRONG)
def test_a_wrong_value_is_named(path, value, problem, bound_json, scene, tmp_path):
    file = tmp_path / "b.json"
    file.write_text(json.dumps(edited(bound_json(scene), path, value)))
    with pytest.raises(InputError, match=problem) as refused:
        read_bound(file)
    assert refused.value.file == str(file)
    assert refused.value.field == ("bound_mm.norm" if problem.endswith("norm") else path)
    assert "simtip bound SCENE" in refused.value.remedy


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "is empty"),
        (b"{", "is not valid JSON"),
        (b"[]", "has to be a mapping"),
        (b"\xff\xfe", "UTF-8"),
        (b'{"bound_mm": {"norm": NaN}}', "NaN"),
        (b'{"bound_mm": {"norm": -Infinity}}', "Infinity"),
        (b'{"bound_mm": {"norm": 1e999}}', "1e999"),
        (b'{"seed": 1, "seed": 2}', "twice"),
        (b"[" * 5000, "nested"),
        (b" " * (1 << 20) + b"{}", "more than the limit"),
    ],
)
def test_what_is_no_bound_is_refused(content, problem, tmp_path):
    file = tmp_path / "b.json"
    file.write_bytes(content)
    with pytest.raises(InputError, match=problem) as refused:
        read_bound(file)
    assert refused.value.file == str(file)
    assert refused.value.remedy


def test_both_forms_of_a_good_one_are_read(bound_json, scene, tmp_path):
    data = bound_json(scene, norm_mm=0.02)
    assert set(data) == KEYS
    file = tmp_path / "b.json"
    for written in (data, {**data, "environment": {}}):
        file.write_text(json.dumps(written))
        bound = read_bound(file)
        assert bound.norm_mm == pytest.approx(0.02)
        bound.require_scene(scene)
    file.write_text(json.dumps({**data, "bound_mm": dict.fromkeys(("x", "y", "z", "norm"))}))
    assert read_bound(file).norm_mm is None


@pytest.mark.parametrize("fault", ["another scene", "missing", "broken"])
def test_run_refuses_in_one_line_and_leaves_nothing(fault, ask, bound_json, scene, tmp_path):
    file = tmp_path / "b.json"
    other = changed(scene, needle={"roll_deg": 1.0})
    if fault != "missing":
        file.write_text(json.dumps(bound_json(other)) if fault == "another scene" else "{}")
    (tmp_path / "scene.yaml").write_text(json.dumps(scene.model_dump(mode="json")))
    before = set(tmp_path.rglob("*"))
    out = str(tmp_path / "out")
    answer = ask("run", str(tmp_path / "scene.yaml"), "--bound", str(file), "-o", out, "--json")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.count("\n") == 1
    assert answer.err.startswith(f"simtip: {file}: ")
    assert "; " in answer.err
    assert set(tmp_path.rglob("*")) == before
