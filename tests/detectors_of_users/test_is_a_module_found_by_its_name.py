"""Does ``package.module:function`` lead to the function, or to one line that says why not?"""

from __future__ import annotations

import sys

import pytest
from programs import GRAY

from simtip import detect
from simtip.errors import InputError


@pytest.fixture
def here(tmp_path, monkeypatch):
    """The current folder, in which modules are forgotten afterwards."""
    monkeypatch.chdir(tmp_path)
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        del sys.modules[name]


def test_it_is_found_in_the_current_folder_and_in_packages(here):
    (here / "mine.py").write_text("import helper\nfind = helper.find\n")
    (here / "helper.py").write_text("def find(image): return (1, 2)\nclass A: find = find\n")
    (here / "pack" / "age").mkdir(parents=True)
    (here / "pack" / "age" / "deep.py").write_text("def find(image): return (3, 4)\n")
    path = list(sys.path)
    assert detect.configure("mine:find")(GRAY).tip_px.tolist() == [1, 2]
    assert detect.configure("helper:A.find")(GRAY).tip_px.tolist() == [1, 2]
    assert detect.configure("pack.age.deep:find")(GRAY).tip_px.tolist() == [3, 4]
    assert sys.path == path
    assert detect.listing("mine:find").source == "module"


BAD = {
    "no module": ("nowhere:find", "there is no module 'nowhere'", "run simtip in the folder"),
    "no submodule": ("mine.sub:find", "there is no module 'mine.sub'", ""),
    "no function": ("mine:fnd", "has no 'fnd'", "did you mean 'find'?"),
    "no part": ("mine:find.sub.part", "has no 'find.sub.part'", ""),
    "no name": ("mine:", "is not package.module:function", "cmd:"),
    "two colons": ("mine:a:b", "is not package.module:function", ""),
    "a path": ("./mine.py:find", "is not package.module:function", ""),
    "code": ("mine:find()", "is not package.module:function", ""),
    "a fault inside": ("broken:find", "ZeroDivisionError: division by zero (broken.py:2", "mend"),
    "a missing import": ("needy:find", "No module named 'absent_thing'", "mend"),
    "no detector": ("mine:NUMBER", "of the type int", "name a function"),
    "an exit": ("leaving:find", "SystemExit: 4", "mend"),
}


@pytest.mark.parametrize(("reference", "problem", "remedy"), BAD.values(), ids=BAD)
def test_what_is_not_there_is_one_line(reference, problem, remedy, here):
    (here / "mine.py").write_text("def find(image): return (1, 2)\nNUMBER = 7\n")
    (here / "broken.py").write_text("\n1 / 0\n")
    (here / "needy.py").write_text("import absent_thing\n")
    (here / "leaving.py").write_text("raise SystemExit(4)\n")
    with pytest.raises(InputError) as caught:
        detect.get(reference)
    assert caught.value.field == "detect.name"
    assert problem in caught.value.problem
    assert remedy in caught.value.remedy
    assert "\n" not in str(caught.value)
