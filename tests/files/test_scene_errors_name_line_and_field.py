"""Does a scene file load strictly, and does each mistake name its line, field and remedy?"""

import contextlib
import copy
import math
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from simtip.errors import InputError
from simtip.scene_file import dump_scene, load_scene, read_scene, scene_schema
from simtip.spec import SceneSpec
from simtip.yaml_file import dump_yaml, undotted

SCENES = Path(__file__).parents[2] / "scenes"
PAPER = SCENES / "01_single_tip.yaml"
SETTINGS = settings(derandomize=True, deadline=None, max_examples=50)

MINIMAL = """\
rig:
  left: {width: 64, height: 48, fx: 100, fy: 100, cx: 31.5, cy: 23.5}
  right: {width: 64, height: 48, fx: 100, fy: 100, cx: 31.5, cy: 23.5}
  R: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
  t_mm: [72, 0, 0]
needle:
  tip: {kind: cone, length_mm: 5}
  tip_mm: [0, 0, 170]
lamps:
  - name: front
    centre_mm: [0, -1500, -600]
    power: 1
    kind: tube
sensor:
  pixel_um: 3.2
  exposure_s: 0.04
"""


def load_text(tmp_path, text):
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return load_scene(path)


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.yaml")), ids=lambda p: p.name)
def test_every_scene_that_comes_with_simtip_loads(path):
    assert isinstance(load_scene(path), SceneSpec)


def test_the_paper_scene_says_what_the_file_says():
    # PyYAML's own safe loader and lax validation are the independent way.
    expected = SceneSpec.model_validate(yaml.safe_load(PAPER.read_text(encoding="utf-8")))
    assert load_scene(PAPER) == expected
    assert load_scene(PAPER).rig.left.fx == 1909.84


def test_a_whole_number_serves_as_a_float_and_a_schema_key_is_ignored(tmp_path):
    spec = load_text(tmp_path, "$schema: ../schema.json\n" + MINIMAL)
    assert spec == load_text(tmp_path, MINIMAL)
    assert isinstance(spec.needle.tip.length_mm, float)


MISTAKES = [
    # (old text, new text, line, field, fragments)
    ("  tip_mm: [0,", "  tip_mn: [0,", 8, "needle.tip_mn",
     ["unknown key", "did you mean 'tip_mm'", "(and 1 more)"]),
    ("length_mm: 5}", "lenght_mm: 5}", 7, "needle.tip.lenght_mm", ["did you mean 'length_mm'"]),
    ("length_mm: 5}", "cone: 5}", 7, "needle.tip.cone", ["unknown key", "kind, length_mm"]),
    ("sensor:", "nedle: {}\nsensor:", 14, "nedle", ["did you mean 'needle'"]),
    ("sensor:", "qqq: {}\nsensor:", 14, "qqq", ["known keys: name, seed, rig"]),
    ("power: 1", "brightness: 1", 12, "lamps[0].brightness", ["unknown key", "known keys"]),
    ("power: 1", "power: '1'", 12, "lamps[0].power", ["a number", "'1'", "without quotes"]),
    ("power: 1", "power: 1 W", 12, "lamps[0].power", ["a number", "'1 W'", "units"]),
    ("power: 1", "power: true", 12, "lamps[0].power", ["a number", "not true"]),
    ("power: 1", "power:", 12, "lamps[0].power", ["a number", "nothing"]),
    ("power: 1", "power: -1", 12, "lamps[0].power", ["from 0 to 1e+09, not -1"]),
    ("power: 1", "power: .nan", 12, "lamps[0].power", ["not a finite number"]),
    ("power: 1", "power: -.inf", 12, "lamps[0].power", ["not a finite number"]),
    ("kind: tube", "kind: bulb", 13, "lamps[0].kind", ["'tube'", "'bulb'"]),
    ("name: front", "name: 5", 10, "lamps[0].name", ["text", "not 5", "quotes"]),
    ("name: front", "name: a b", 10, "lamps[0].name", ["pattern", "'a b'"]),
    ("name: front", "name: ambient", 9, "lamps", ["'ambient' is taken"]),
    ("[0, -1500, -600]", "[0, -1500]", 11, "lamps[0].centre_mm", ["has 2 entries", "give 3"]),
    ("[0, -1500, -600]", "[0, 1, 2, 3]", 11, "lamps[0].centre_mm", ["has 4 entries", "give 3"]),
    ("[0, -1500, -600]", "{x: 1}", 11, "lamps[0].centre_mm", ["a list", "not a mapping"]),
    ("[0, -1500, -600]", "[0, a, 1]", 11, "lamps[0].centre_mm[1]", ["a number", "'a'"]),
    ("kind: cone", "kind: conic", 7, "needle.tip.kind", ["'cone' or 'bevel'", "'conic'"]),
    ("kind: cone", "kind: 3", 7, "needle.tip.kind", ["'cone' or 'bevel'", "not 3"]),
    ("{kind: cone, length_mm: 5}", "{length_mm: 5}", 7, "needle.tip.kind", ["is missing"]),
    ("{kind: cone, length_mm: 5}", "cone", 7, "needle.tip", ["a mapping", "'cone'"]),
    ("length_mm: 5}", "length_mm: -5}", 7, "needle.tip.length_mm", ["from 1e-06 to 1e+06, not -5"]),
    ("{kind: cone, length_mm: 5}", "{kind: bevel, angle_deg: 95}", 7, "needle.tip.angle_deg",
     ["at least 1 and below 90"]),
    ("  tip_mm: [0, 0, 170]\n", "", 6, "needle.tip_mm", ["is missing", "add it"]),
    ("[[1, 0, 0], [0, 1, 0]", "[[1, 0, 0], [0, 1]", 4, "rig.R[1]", ["has 2 entries", "give 3"]),
    ("[0, 0, 1]]", "[0, 0, 0.9]]", 4, "rig.R", ["not a rotation"]),
    ("[0, 0, 1]]", "[0, 0, -1]]", 4, "rig.R", ["mirrors"]),
    ("[0, 0, 1]]", "[0, 1.e+200, 1.e+200]]", 4, "rig.R[2][1]", ["from -1.01 to 1.01"]),
    ("t_mm: [72, 0, 0]", "t_mm: [0, 0, 0]", 5, "rig.t_mm", ["baseline is 0 mm"]),
    ("left: {width: 64", "left: {width: 64.0", 2, "rig.left.width", ["whole number", "64.0"]),
    ("left: {width: 64", "left: {width: 0", 2, "rig.left.width", ["from 1 to 32768"]),
    ("left: {width: 64", "left: {roi: [0, 0, 99, 1], width: 64", 2, "rig.left.roi", ["[0, 0, 99"]),
    ("left: {width: 64", "left: {lens: {vignetting: [0, 0, 0, 0, 0]}, width: 64", 2,
     "rig.left.lens.vignetting", ["has 5 entries", "give at most 4"]),
    ("left: {width: 64", "left: {lens: {focus_mm: 5}, width: 64", 2, "rig.left.lens.focus_mm",
     ["above 6 mm"]),
    ("  exposure_s: 0.04", "  quantum_efficiency: [0.5, 1.2, 0.5]", 16,
     "sensor.quantum_efficiency[1]", ["from 0 to 1, not 1.2"]),
    ("  exposure_s: 0.04", "  background_dn: 0", 16, "sensor.background_dn", ["above 0"]),
    ("  exposure_s: 0.04", "  bit_depth: 9.5", 16, "sensor.bit_depth", ["8, 10, 12 or 16"]),
    ("  exposure_s: 0.04", "  exposure_s: -0.04", 16, "sensor.exposure_s", ["from 1e-06 to 100"]),
    ("  exposure_s: 0.04", "  exposure_s: 0.04\n  noise: 1", 17, "sensor.noise",
     ["true or false", "not 1"]),
    ("sensor:", "match: [1]\nsensor:", 14, "match", ["a mapping of keys", "a list of 1"]),
    ("sensor:", "triangulate: {method: s}\nsensor:", 14, "triangulate.method", ["'midpoint'"]),
    ("sensor:", "seed: 1e3\nsensor:", 14, "seed", ["whole number"]),
    ("sensor:", "seed: -1\nsensor:", 14, "seed", ["at least 0 and below 9.22"]),
    ("sensor:", f"seed: {10**30}\nsensor:", 14, "seed", ["at least 0 and below"]),
    ("sensor:", "detect: {name: 3}\nsensor:", 14, "detect.name", ["text"]),
    ("sensor:", "detect: {threshold: .inf}\nsensor:", 14, "detect.threshold", ["finite"]),
    ("sensor:", "name: !!python/none x\nsensor:", 14, "name", ["!!python/none"]),
    ("    kind: tube\n", "    kind: tube\n  - 5\n", 14, "lamps[1]", ["a mapping of keys", "not 5"]),
    (MINIMAL, "[1, 2]", 1, None, ["mapping of keys", "a list of 2"]),
    (MINIMAL, "text", 1, None, ["mapping of keys", "'text'"]),
    (MINIMAL, "{}", 1, "rig", ["is missing", "(and 1 more)"]),
    (MINIMAL[MINIMAL.index("lamps") : MINIMAL.index("sensor")], "", 1, "lamps",
     ["there is no light"]),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line", "field", "fragments"), MISTAKES)
def test_a_mistake_names_its_line_and_field(tmp_path, *, old, new, line, field, fragments):
    assert MINIMAL.count(old) == 1
    with pytest.raises(InputError) as caught:
        load_text(tmp_path, MINIMAL.replace(old, new))
    error = caught.value
    message = str(error)
    assert (error.line, error.field) == (line, field)
    assert message.startswith(f"{tmp_path / 'scene.yaml'}:{line}: ")
    assert error.remedy
    for fragment in fragments:
        assert fragment in message
    assert "\n" not in message
    assert "pydantic" not in message
    assert "Input should" not in message


@pytest.mark.parametrize(
    "tip", ["{kind: bevel, angle_deg: 1.e-320}", "{kind: cone, length_mm: 1.e-320}"]
)
def test_values_beyond_arithmetic_are_no_crash(tmp_path, tip):
    with contextlib.suppress(InputError):
        assert load_text(tmp_path, MINIMAL.replace("{kind: cone, length_mm: 5}", tip))


def test_a_mistake_behind_an_alias_names_the_line_where_it_is_written(tmp_path):
    text = MINIMAL.replace("  left: {", "  left: &cam {").replace("fx: 100,", "fx: -1,", 1)
    right = text[text.index("  right") : text.index("  R:")]
    with pytest.raises(InputError) as caught:
        load_text(tmp_path, text.replace(right, "  right: *cam\n"))
    assert (caught.value.line, caught.value.field) == (2, "rig.left.fx")


def test_other_modules_can_name_a_field_and_its_line():
    scene = read_scene(PAPER)
    lines = PAPER.read_text(encoding="utf-8").splitlines()
    for field, start in {
        "needle.tip_mm": "  tip_mm:",
        "needle.tip.length_mm": "  tip: {",
        "lamps[1].name": "  - {name: rear",
        "rig.R[1][2]": "    - [0.036",
        "detect.window": "detect:",  # not written: its nearest part
    }.items():
        assert lines[scene.line_of(field) - 1].startswith(start)
    error = scene.error("has to be odd", "detect.threshold", remedy="give 5")
    line = scene.line_of("detect.threshold")
    assert str(error) == f"{PAPER}:{line}: detect.threshold: has to be odd; give 5"


def test_the_paper_scene_round_trips(tmp_path):
    spec = load_scene(PAPER)
    assert load_text(tmp_path, dump_scene(spec)) == spec


NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=True)
POSITIVE = st.floats(1e-300, 1e300)
TEXT = st.text(st.characters(exclude_categories=["C"]), max_size=30)
PLAIN = st.none() | st.booleans() | st.integers() | NUMBERS | TEXT | st.lists(NUMBERS, max_size=3)


@pytest.mark.slow
@SETTINGS
@given(
    name=TEXT | st.sampled_from(["yes", "1e-3", "08", "0o7", "null", "~", "<<", " x ", "a: b"]),
    seed=st.integers(0, 2**63 - 1),
    tip=st.tuples(NUMBERS, NUMBERS, NUMBERS),
    power=st.floats(0, 1e9),
    bevel=st.floats(20, 80) | st.none(),
    detect=st.dictionaries(TEXT.filter(lambda k: k != "name"), PLAIN, max_size=3),
)
def test_any_scene_round_trips_exactly(tmp_path_factory, **drawn):
    data = copy.deepcopy(yaml.safe_load(MINIMAL))
    data |= {"name": drawn["name"], "seed": drawn["seed"]}
    data["detect"] = {"name": "lin2020", **drawn["detect"]}
    data["needle"]["tip_mm"] = drawn["tip"]
    data["lamps"][0]["power"] = drawn["power"]
    if drawn["bevel"] is not None:
        data["needle"]["tip"] = {"kind": "bevel", "angle_deg": drawn["bevel"]}
    spec = SceneSpec.model_validate(data)
    again = load_text(tmp_path_factory.getbasetemp(), dump_scene(spec))
    assert again == spec
    assert again.model_dump() == spec.model_dump()
    assert math.copysign(1, again.needle.tip_mm[0]) == math.copysign(1, spec.needle.tip_mm[0])


KEYS = [
    "rig",
    "needle",
    "lamps",
    "tip",
    "kind",
    "sensor",
    "R",
    "left",
    "detect",
    "roi",
    "cone",
    "x",
]
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 10**30) | st.floats() | st.sampled_from(KEYS),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(KEYS), inner, max_size=3)
    ),
    max_leaves=6,
)
FIELDS = [
    "rig", "rig.R", "rig.R[0]", "rig.R[1][1]", "rig.t_mm", "rig.left", "rig.left.width", "needle",
    "needle.tip", "needle.tip.kind", "needle.tip_mm", "lamps", "lamps[0]", "lamps[0].name",
    "lamps[0].rgb", "sensor", "sensor.bit_depth", "sensor.exposure_s", "detect",
    "background.normal", "triangulate", "seed", "name",
]  # fmt: skip


@SETTINGS
@given(st.sampled_from(FIELDS), VALUES)
def test_no_other_error_escapes_from_any_value_anywhere(tmp_path_factory, field, value):
    data = copy.deepcopy(yaml.safe_load(MINIMAL))
    data["background"] = {}
    data["sensor"]["bit_depth"] = 8
    *inner, last = undotted(field)
    part = data
    for key in inner:
        part = part[key]
    part[last] = value
    with contextlib.suppress(InputError):
        assert isinstance(load_text(tmp_path_factory.getbasetemp(), dump_yaml(data)), SceneSpec)


def test_the_schema_describes_the_keys_of_a_scene():
    schema = scene_schema()
    assert schema["$schema"].startswith("https://json-schema.org/")
    assert schema["title"] == "simtip scene"
    assert schema["additionalProperties"] is False
    assert set(schema["properties"]) == {"$schema", *SceneSpec.model_fields}
    assert schema["required"] == ["rig", "needle"]
    needle = schema["$defs"]["NeedleSpec"]
    assert "apex" in needle["properties"]["tip_mm"]["description"]
    assert needle["required"] == ["tip_mm"]
    assert schema["$defs"]["CameraSpec"]["properties"]["width"]["maximum"] == 32768


def test_every_reference_in_the_schema_leads_somewhere():
    schema = scene_schema()
    references = []

    def collect(node):
        if isinstance(node, dict):
            references.extend(v for k, v in node.items() if k == "$ref")
            for child in node.values():
                collect(child)
        elif isinstance(node, list):
            for child in node:
                collect(child)

    collect(schema)
    assert len(references) > 10
    assert {r.removeprefix("#/$defs/") for r in references} <= set(schema["$defs"])
