"""Is YAML read as plain data by the core schema, and is all that is hostile refused in one line?"""

import contextlib
import math
import os
import time

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from simtip import input_file
from simtip.errors import InputError
from simtip.yaml_file import dotted, dump_yaml, load_yaml, parse_yaml, undotted

SETTINGS = settings(derandomize=True, deadline=None, max_examples=100)


def value(text, **options):
    data = text if isinstance(text, bytes) else text.encode()
    return parse_yaml(data, "f.yaml", **options).value


CORE_SCHEMA = {
    "~": None,
    "null": None,
    "": None,
    "true": True,
    "False": False,
    "yes": "yes",
    "no": "no",
    "on": "on",
    "y": "y",
    "12": 12,
    "-12": -12,
    "+3": 3,
    "010": 10,
    "08": 8,
    "0o17": 15,
    "0xfF": 255,
    "0b1": "0b1",
    "1_000": "1_000",
    "1:30": "1:30",
    "2001-01-01": "2001-01-01",
    "1e-3": 1e-3,
    "1E5": 1e5,
    "-.5": -0.5,
    "1.": 1.0,
    "-2.5e+3": -2500.0,
    "1.5.2": "1.5.2",
    "e3": "e3",
    ".": ".",
    ".inf": math.inf,
    "-.Inf": -math.inf,
    "+.INF": math.inf,
    "inf": "inf",
    "nan": "nan",
    ".Nan": ".Nan",
    "=": "=",
    "٣": "٣",
    "'5'": "5",
    '"true"': "true",
    "|-\n  5": "5",
}


@pytest.mark.parametrize(("text", "expected"), CORE_SCHEMA.items())
def test_a_scalar_has_its_core_schema_value(text, expected):
    found = value(f"a: {text}\n")["a"]
    assert found == expected
    assert type(found) is type(expected)


def test_not_a_number_is_a_float():
    assert math.isnan(value("a: .nan")["a"])
    assert math.isnan(value("a: .Nan", opencv=True)["a"])


BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 20)
)
MERGE_BOMB = "a0: &a0 {k: [x, x, x, x, x, x, x, x, x, x]}\n" + "".join(
    f"a{i}: &a{i} {{{', '.join(f'k{j}: *a{i - 1}' for j in range(10))}, <<: *a{i - 1}}}\n"
    for i in range(1, 20)
)
LONG_TEXT_BOMB = f"a: &a {'x' * 100_000}\nb: [{', '.join(['*a'] * 1000)}]"
DEEP_ALIASES = "a0: &a0 [x]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 5000))

HOSTILE = [
    # content, line, fragments of the message
    (b"", None, ["is empty"]),
    (b"# nothing\n", None, ["is empty"]),
    (b"---\n", None, ["is empty"]),
    (b"~\n", None, ["is empty"]),
    (b"a: 1\nb: \xff\n", 2, ["not UTF-8", "0xff", "save it as UTF-8"]),
    ("a: 1\n".encode("utf-16"), 1, ["not UTF-8"]),
    (b"a: 1\nb: \x00\n", 2, ["control character U+0000"]),
    (b"a: 1\nb: \x1b[31m\n", 2, ["control character U+001B"]),
    (b'a: 1\nb: "\\0"\n', 2, ["b", "control character U+0000"]),
    (b'a: "\\x1b[31m"\n', 1, ["control character U+001B"]),
    (b'a: "\\uD800"\n', 1, ["control character U+D800"]),
    (b'a: "\\UFFFFFFFF"\n', None, ["not valid YAML"]),
    (b"%YAML 1." + b"1" * 5000 + b"\n---\na: 1", None, ["not valid YAML"]),
    (b"%YAML:1.0\n---\na: 1", 1, ["not valid YAML"]),
    (b"a: 1\n b: 2\n", 2, ["not valid YAML", "mapping values are not allowed"]),
    (b"a: [1, 2\n", 2, ["not valid YAML"]),
    (b"a: 'x\n", 2, ["not valid YAML"]),
    (b"a:\n\tb: 1\n", 2, ["not valid YAML"]),
    (
        b"x: 1\na: !!python/object/apply:os.system [ls]\n",
        2,
        ["!!python/object/apply:os.system", "plain values only"],
    ),
    (b"a: !!python/name:os.system\n", 1, ["!!python/name:os.system"]),
    (b"a: !mine 3\n", 1, ["!mine", "plain values only"]),
    (b"a: !!str 3\n", 1, ["!!str"]),
    (b"a: ! 3\n", 1, ["tag !"]),
    (b"!!map {a: 1}\n", 1, ["!!map"]),
    (b"!!str a: 1\n", 1, ["!!str"]),
    (b"a: !!opencv-matrix {rows: 1}\n", 1, ["!!opencv-matrix"]),
    (b"a: !" + b"x" * 100_000 + b" 1\n", 1, ["xxx..."]),
    (b"a: 1\nb: 2\na: 3\n", 3, ["duplicate key 'a'", "line 1"]),
    (b"p:\n  a: 1\n  'a': 3\n", 3, ["p", "duplicate key 'a'"]),
    (b"1: x\n", 1, ["key 1 is not text", "quotes"]),
    (b"true: x\n", 1, ["key true is not text"]),
    (b"~: x\n", 1, ["key ~ is not text"]),
    (b"? [a]\n: x\n", 1, ["key is a list"]),
    (b"? {a: 1}\n: x\n", 1, ["key is a list or a mapping"]),
    (b"a: &a k\n*a : 1\n", 2, ["alias *a is a key"]),
    (b"a: 1\n---\nb: 1\n", 2, ["more than one document"]),
    (b"a: &a [1, *a]\n", 1, ["*a contains itself"]),
    (b"a: &a {b: {<<: *a}}\n", 1, ["*a contains itself"]),
    (b"a: *b\n", 1, ["*b has no anchor"]),
    (b"a: {<<: 3}\n", 1, ["not a mapping"]),
    (b"a: {<<: [{b: 1}, 3]}\n", 1, ["not a mapping"]),
    (b"a: &a {b: 1}\nc: {<<: *a, <<: *a}\n", 2, ["duplicate key '<<'"]),
    (BOMB.encode(), 5, ["expands to more than"]),
    (MERGE_BOMB.encode(), 5, ["expands to more than"]),
    (LONG_TEXT_BOMB.encode(), 2, ["expands to more than"]),
    (DEEP_ALIASES.encode(), None, ["nested deeper than 64"]),
    (b"[" * 100_000, 1, ["nested deeper than 64"]),
    (b"{a: " * 50_000, 1, ["nested deeper than 64"]),
    (b"- " * 100_000, 1, ["nested deeper than 64"]),
    (b"? " * 100_000, 1, ["key is a list or a mapping"]),
    (b"\n".join(b" " * i + b"a:" for i in range(400)), 65, ["nested deeper than 64"]),
    pytest.param(b"[" + b"1," * 51_000 + b"]", 1, ["expands to more than"], marks=pytest.mark.slow),
    pytest.param(
        b"{" + b",".join(b"a%d" % i for i in range(26_000)) + b"}",
        1,
        ["expands to more than"],
        marks=pytest.mark.slow,
    ),
    (b"a: " + b"9" * 5000, 1, ["a", "5000 characters", "too long"]),
    (b"a: 0x" + b"f" * 5000, 1, ["too long"]),
    (b"a: 1e999", 1, ["1e999", "too large"]),
    (b"x: 1\n" * 60_000, None, ["more than the limit"]),
]


@pytest.mark.parametrize(("content", "line", "fragments"), HOSTILE)
def test_a_hostile_file_is_one_line_that_names_the_place(content, line, fragments, tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_bytes(content)
    start = time.perf_counter()
    with pytest.raises(InputError) as caught:
        load_yaml(path)
    assert time.perf_counter() - start < 10
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert len(message) < len(str(path)) + 300
    assert message.isprintable()
    if line is not None:
        assert caught.value.line == line
    for fragment in fragments:
        assert fragment in message


def test_what_is_no_regular_file_is_refused(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    file = tmp_path / "file"
    file.write_text("a: 1")
    for path, fragment in {
        tmp_path / "none.yaml": "no such file",
        file / "below": "no such file",
        tmp_path: "is a folder",
        "": "is a folder",
        pipe: "not a regular file",
        "/dev/zero": "not a regular file",
        tmp_path / ("x" * 300): "cannot be read",
        "a\0b": "cannot be read",
    }.items():
        with pytest.raises(InputError, match=fragment):
            load_yaml(path)


def test_a_file_without_permission_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a.yaml"
    path.write_text("a: 1")

    def refuse(*_args, **_kwargs):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(input_file.Path, "open", refuse)
    with pytest.raises(InputError, match="may not be read"):
        load_yaml(path)


def test_lines_are_those_of_the_text():
    text = "# c\na: 1\nb:\n  c: [1,\n    2]\n  d:\n    - x: 1\n    -\n      y: 2\n"
    document = parse_yaml(text.encode(), "f")
    assert document.lines == {
        (): 2,
        ("a",): 2,
        ("b",): 3,
        ("b", "c"): 4,
        ("b", "c", 0): 4,
        ("b", "c", 1): 5,
        ("b", "d"): 6,
        ("b", "d", 0): 7,
        ("b", "d", 0, "x"): 7,
        ("b", "d", 1): 9,
        ("b", "d", 1, "y"): 9,
    }
    assert document.line(("b", "missing", "below")) == 3
    assert str(document.error("bad", ("b", "d", 1))) == "f:9: b.d[1]: bad"


def test_aliases_and_merge_keys_are_followed():
    text = "a: &a {x: 1, y: 2}\nb: &b {z: 5}\nc: {<<: [*a, *b], y: 3}\nd: [*a, *a]\n"
    document = parse_yaml(text.encode(), "f")
    assert document.value == yaml.safe_load(text)
    assert document.line(("c", "y")) == 3
    assert document.line(("c", "x")) == 1
    assert document.line(("d", 1, "y")) == 1


def test_a_byte_order_mark_and_windows_line_ends_are_harmless():
    document = parse_yaml(b"\xef\xbb\xbfa: 1\r\nb: 2\r\n", "f")
    assert document.value == {"a": 1, "b": 2}
    assert document.line(("b",)) == 2


def test_nesting_up_to_the_limit_is_read():
    assert value("[" * 64 + "]" * 64)
    with pytest.raises(InputError, match="deeper"):
        value("[" * 65 + "]" * 65)


def test_opencv_files_keep_their_line_numbers():
    text = b"%YAML:1.0\n---\nM: !!opencv-matrix\n   rows: 1\n"
    document = parse_yaml(text, "f", opencv=True)
    assert document.value == {"M": {"rows": 1}}
    assert document.line(("M", "rows")) == 4
    with pytest.raises(InputError, match="python"):
        value("a: !!python/none x", opencv=True)


PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**40), 10**40)
    | st.floats(allow_nan=False)
    | st.sampled_from([k for k in CORE_SCHEMA if "\n" not in k] + ["<<", "- a", "#", "1e5", "!x"])
    | st.text(st.characters(exclude_categories=["C"]), max_size=60),
    lambda children: (
        st.lists(children, max_size=4)
        | st.dictionaries(
            st.text(st.characters(exclude_categories=["C"]), max_size=12), children, max_size=4
        )
    ),
    max_leaves=12,
)


@SETTINGS
@given(PLAIN)
def test_what_is_dumped_is_read_back_exactly(data):
    wrapped = {"value": data}
    assert repr(value(dump_yaml(wrapped))) == repr(wrapped)


@SETTINGS
@given(st.binary(max_size=60) | st.text("{}[]&*a!%:,-?|>'\"\\#\n\t 01.e<x", max_size=60))
def test_no_other_error_escapes_from_any_bytes(data):
    for opencv in (False, True):
        with contextlib.suppress(InputError):
            assert value(data, opencv=opencv) is not None


@SETTINGS
@given(
    st.lists(
        st.text("abcXYZ_019-$", min_size=1, max_size=5) | st.integers(0, 10**6),
        max_size=5,
    )
)
def test_dotted_paths_read_back(path):
    assert undotted(dotted(tuple(path))) == tuple(path)
