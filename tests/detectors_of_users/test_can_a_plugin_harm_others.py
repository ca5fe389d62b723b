"""Are installed plug-ins found, and is one that is broken listed with its fault and no more?"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from programs import GRAY

from simtip import detect
from simtip.errors import InputError

BUILT_IN = ("lin2020", "subpixel")


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Lay out a distribution as pip does; give the folder, which is on Python's path."""
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(str(site))
    before = set(sys.modules)

    def lay_out(name: str, points: str, **modules: str) -> Path:
        info = site / f"{name.replace('-', '_')}-1.2.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.2\n")
        (info / "entry_points.txt").write_text(f"[simtip.detectors]\n{points}\n")
        for module, text in modules.items():
            (site / f"{module}.py").write_text(text)
        return info

    yield lay_out
    for name in set(sys.modules) - before:
        del sys.modules[name]


GOOD = 'def find(image, *, u: int = 3):\n    """Find it."""\n    return (u, 4)\n'


def listed():
    return {item.name: item for item in detect.catalogue()}


def test_a_plugin_is_a_detector_by_name(install):
    install("good-ones", "pointed = plug_good:find", plug_good=GOOD)
    assert detect.names() == (*sorted({*BUILT_IN, "pointed"}),)
    assert "plug_good" not in sys.modules, "names() imports nothing"
    assert detect.configure("pointed", {"u": "5"})(GRAY).tip_px.tolist() == [5, 4]
    assert [p.name for p in detect.parameters_of("pointed")] == ["u"]
    item = listed()["pointed"]
    assert item.source == "plug-in of good-ones 1.2 (plug_good:find)"
    assert (item.detector.summary, item.fault) == ("Find it.", "")
    assert detect.listing("pointed").source == item.source
    with pytest.raises(InputError, match="did you mean 'pointed'"):
        detect.get("ponited")


BROKEN = {
    "an import that fails": ("plug_a:find", "import nothing_of_this_name", "ModuleNotFoundError"),
    "no such module": ("plug_none:find", "", "ModuleNotFoundError"),
    "an exception": ("plug_a:find", "raise RuntimeError('no licence')", "no licence"),
    "an exit": ("plug_a:find", "import sys; sys.exit(1)", "SystemExit"),
    "no Python": ("plug_a:find", "def find(:", "SyntaxError"),
    "no such object": ("plug_a:fnd", GOOD, "AttributeError"),
    "a class": ("plug_a:Find", "class Find: pass", "is a class"),
    "no image": ("plug_a:find", "def find(): pass", "takes no image"),
    "wild parameters": (
        "plug_a:find",
        "class D:\n    parameters = 7\n    configure = None\n    def __call__(self): 0\nfind = D()",
        "TypeError",
    ),
    "no reference at all": ("??", "", ""),
}


@pytest.mark.parametrize(("value", "text", "fault"), BROKEN.values(), ids=BROKEN)
def test_a_broken_one_is_listed_with_its_fault_and_hinders_no_other(value, text, fault, install):
    install("bad-ones", f"bent = {value}", plug_a=text)
    install("good-ones", "pointed = plug_good:find", plug_good=GOOD)
    found = listed()
    assert set(found) == {*BUILT_IN, "pointed", "bent"}
    assert found["bent"].detector is None
    assert found["bent"].fault
    assert fault in found["bent"].fault
    assert "\n" not in found["bent"].fault
    assert detect.configure("pointed")(GRAY).ok
    with pytest.raises(InputError, match="'bent' cannot be used") as caught:
        detect.get("bent")
    assert caught.value.remedy == "mend or remove bad-ones 1.2"


def test_metadata_that_cannot_be_read_hides_no_other(install):
    info = install("bad-ones", "")
    (info / "entry_points.txt").write_bytes(b"[simtip.detectors]\nno equals sign\n\xff\n")
    install("good-ones", "pointed = plug_good:find", plug_good=GOOD)
    assert set(listed()) == {*BUILT_IN, "pointed"}


def test_none_takes_the_place_of_a_built_in_one(install):
    install("bad-ones", "lin2020 = plug_a:find", plug_a=GOOD)
    assert detect.names() == BUILT_IN
    assert not detect.configure("lin2020")(GRAY).ok
    shadow = [item for item in detect.catalogue() if item.name == "lin2020"]
    assert len(shadow) == 2
    assert shadow[0].source == "built in"
    assert "is built in" in shadow[1].fault
    assert "plug_a" not in sys.modules


def test_two_that_claim_one_name_are_both_refused(install):
    install("one", "pointed = plug_good:find", plug_good=GOOD)
    install("two", "pointed = plug_good:find")
    assert detect.names() == BUILT_IN
    with pytest.raises(InputError, match=r"claimed 2 times, by one 1\.2, two 1\.2"):
        detect.get("pointed")


@pytest.mark.usefixtures("install")
def test_the_command_line_lists_them(install, ask):
    install("bad-ones", "bent = plug_a:find", plug_a="print('chatter')\nraise ValueError")
    install("good-ones", "pointed = plug_good:find", plug_good=GOOD)
    answer = ask("detectors", "--json")
    assert answer.code == 0
    items = {item["name"]: item for item in json.loads(answer.out)}
    assert set(items) == {*BUILT_IN, "pointed", "bent"}
    assert items["bent"]["fault"].startswith("ValueError")
    assert answer.err == "chatter\n"
    assert items["pointed"]["parameters"] == [
        {"name": "u", "type": "int", "default": 3, "required": False, "description": ""}
    ]
    text = ask("detectors").out
    for word in ("threshold", "plug-in of good-ones 1.2", "cannot be used: ValueError", "Find it."):
        assert word in text
    one = json.loads(ask("detectors", "pointed", "--json").out)
    assert one == items["pointed"]
    assert json.loads(ask("detectors", "--json", "pointed").out) == one
    assert ask("detectors", "bent").code == 2
