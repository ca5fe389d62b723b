from __future__ import annotations

import pytest

from simtip.render.backend import Verdict


def complaints(done: pytest.RunResult) -> list[str]:
    """Give the one line of each of a run's failures, in their order."""
    said = done.stdout.str() + done.stderr.str()
    assert "Traceback" not in said
    assert "factory.py" not in said
    assert "INTERNALERROR" not in said
    assert "During handling" not in said
    return [one.removeprefix("simtip: ") for one in done.outlines if one.startswith("simtip: ")]


def complaint(done: pytest.RunResult) -> str:
    """Give the one line of a run's only failure."""
    (line,) = complaints(done)
    return line


def check(mine, done: pytest.RunResult, mistakes: list[tuple[str, str]]) -> None:
    """See that each mistake is said, and nothing else."""
    for line, (made, said) in zip(complaints(done), mistakes, strict=True):
        assert line.replace(f"{mine.path}/", "").startswith(said), (made, line)


IN_A_TEST = [
    ("simtip_pair('none.yaml')", "there is no scene 'none.yaml' in "),
    ("simtip_pair('/none.yaml')", "there is no scene '/none.yaml'; name another file"),
    (
        "simtip_pair(5)",
        "a scene is a file, a SceneSpec or standard:NAME, not int; give one of them",
    ),
    ("simtip_pair('broken.yaml')", "broken.yaml:60: needle.tip_m: unknown key"),
    ("simtip_pair('tiny.yaml', -1)", "seed: is -1; give a whole number from 0 to 2**63 - 1"),
    ("simtip_pair('tiny.yaml', 1.0)", "seed: is 1.0; give a whole number from 0 to 2**63 - 1"),
    ("simtip_pair('tiny.yaml', True)", "seed: is True; give a whole number"),
    (
        "simtip_pair('tiny.yaml', changes={'needle.rol_deg': 1})",
        "needle.rol_deg: is no field of the scene; did you mean 'needle.roll_deg'?",
    ),
    ("simtip_pair('tiny.yaml', changes={'needle.roll_deg': 'x'})", "needle.roll_deg: "),
    (
        "simtip_pair('tiny.yaml', changes={'needle.roll_deg': {1}})",
        "needle.roll_deg: is of the type set",
    ),
    (
        "simtip_pair('tiny.yaml', changes={1: 2})",
        "changes: is {1: 2}; give fields with their values, as {'sensor.exposure_s': 0.02}",
    ),
    ("simtip_pair('tiny.yaml', changes='abc')", "changes: is 'abc'; give fields"),
    ("simtip_pair('x' * 300)", "there is no scene 'xxx"),
    ("simtip_pair('tiny.yaml', changes={'rig.measured': 'x' * 300})", "there is no rig 'xxx"),
    (
        "simtip_pair('tiny.yaml', changes={'lamps[-1].power': 1})",
        "lamps[-1].power: counts from the end",
    ),
    ("simtip_pair('tiny.yaml', changes={'needle.tip_mm': [0, 0, -9]})", "needle.tip_mm: "),
    (
        "simtip_pair('tiny.yaml', changes={'rig.measured': 'no.yaml'})",
        "there is no rig 'no.yaml' in ",
    ),
    (
        "simtip_pair('standard:nominl')",
        "the suite 'standard' has no case 'nominl'; did you mean 'nominal'?",
    ),
    (
        "simtip_pair('standard:lamps')",
        "lamps[0].power: varies in the case 'lamps' of the suite standard; give it in changes",
    ),
    (
        "simtip_pair('tiny.yaml').measure('lin202')",
        "detect.name: there is no detector 'lin202'; did you mean",
    ),
    ("simtip_pair('tiny.yaml').measure('lin2020', threshol=1)", "detect.threshol: "),
    ("simtip_pair('tiny.yaml').measure(lowest_dark, levl=1)", "detect.levl: "),
    (
        "simtip_pair('tiny.yaml').measure(5)",
        "detect.name: int is of the type int, not a detector",
    ),
    ("simtip_pair('tiny.yaml').assert_tip_within(lowest_dark)", "the assertion has no limit"),
    (
        "simtip_pair('tiny.yaml').assert_tip_within(lowest_dark, px=-2)",
        "px: is -2; give a number from 0 on",
    ),
    ("simtip_pair('tiny.yaml').assert_tip_within(lowest_dark, px=10**400)", "px: is 10000"),
]


def test_in_a_test(mine):
    scene = (mine.path / "tiny.yaml").read_text()
    mine.write("broken.yaml", scene.replace("tip_mm:", "tip_m:"))
    mine.test(
        "\n".join(
            f"def test_{k}(simtip_pair):\n    {call}" for k, (call, _) in enumerate(IN_A_TEST)
        )
    )
    done = mine.run()
    done.assert_outcomes(failed=len(IN_A_TEST))
    check(mine, done, IN_A_TEST)


IN_A_MARKER = [
    ("suite='none.yaml'", "@pytest.mark.simtip: there is no suite 'none.yaml' in "),
    ("cases=['nominl']", "the suite 'standard' has no case 'nominl'; did you mean 'nominal'?"),
    ("cases=[]", "@pytest.mark.simtip: has cases=[]; give a list of names"),
    ("cases=[3]", "@pytest.mark.simtip: has cases=[3]; give a list of names"),
    ("repeats=0", "@pytest.mark.simtip: has repeats=0; give a whole number from 1 on"),
    ("repeats=True", "@pytest.mark.simtip: has repeats=True; give a whole number from 1 on"),
    ("case='nominal'", "@pytest.mark.simtip: knows no 'case'; known: suite, cases, repeats"),
    ("'standard'", "@pytest.mark.simtip: takes names only; write e.g. suite='standard'"),
    ("suite='broken.yaml'", "broken.yaml:1: cases: is missing"),
    ("suite='odd.yaml'", "odd.yaml:2: needle.rol_deg: is no field of the scene"),
]


def test_in_a_marker(mine):
    mine.write("broken.yaml", "name: broken\n")
    mine.write(
        "odd.yaml",
        "name: odd\ncases: [{name: a, scene: tiny.yaml, repeats: 2, base: {needle.rol_deg: 1}}]\n",
    )
    for k, (marked, _) in enumerate(IN_A_MARKER):
        body = f"@pytest.mark.simtip({marked})\ndef test(simtip_suite): ..."
        mine.test(body, f"test_{k:02}.py")
    done = mine.run("--continue-on-collection-errors")
    done.assert_outcomes(errors=len(IN_A_MARKER))
    check(mine, done, IN_A_MARKER)


@pytest.mark.parametrize("share", [0, 2, "'x'", None, "float('nan')", "[1]"])
def test_in_a_share(mine, share):
    mine.test(
        "@pytest.mark.simtip(suite='suite.yaml', cases='nominal')\n"
        "def test(simtip_suite):\n"
        f"    simtip_suite.assert_tips_within(lowest_dark, px=9, share={share})"
    )
    done = mine.run()
    done.assert_outcomes(failed=1)
    assert complaint(done).startswith("share: is ")


@pytest.mark.parametrize(
    "asked",
    [
        "def test(request):\n    request.getfixturevalue('simtip_suite')",
        (
            "import unittest\n"
            "class TestCases(unittest.TestCase):\n"
            "    @pytest.fixture(autouse=True)\n"
            "    def keep(self, simtip_suite): ...\n"
            "    def test(self): ..."
        ),
    ],
)
def test_where_pytest_cannot_run_a_test_once_a_case(mine, asked):
    mine.test(asked)
    done = mine.run()
    assert done.ret == 1
    line = complaint(done)
    assert line.startswith("simtip_suite: is there only for tests that pytest can run once a case")


@pytest.mark.parametrize("option", ["suite", "cache", "backend", "artifacts"])
def test_an_option_that_says_nothing(mine, option):
    """Or an unset variable of a shell would make the working folder a cache."""
    mine.test("def test(simtip_pair): ...")
    done = mine.run(f"--simtip-{option}=")
    assert done.ret == pytest.ExitCode.USAGE_ERROR
    said = done.stderr.str()
    assert f"argument --simtip-{option}: is empty; name something, or leave it out" in said


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (
            "--simtip-backend=gpu",
            "--simtip-backend: there is no back end 'gpu'; choose from auto, cuda, llvm, scalar",
        ),
        ("--simtip-seed=-1", "--simtip-seed: is -1; give a whole number from 0 to 2**63 - 1"),
        (
            "--simtip-cache=tiny.yaml",
            "tiny.yaml: cannot be used as a cache (Not a directory); name another folder",
        ),
        ("--simtip-suite=none.yaml", "--simtip-suite: there is no suite 'none.yaml' in "),
        (f"--simtip-suite={'x' * 300}", "--simtip-suite: there is no suite 'xxx"),
    ],
)
def test_on_the_command_line(mine, option, said):
    if "suite" in option:
        mine.test("def test(simtip_suite): ...")
    else:
        mine.test("def test(simtip_pair): ...")
    done = mine.run(option)
    done.assert_outcomes(errors=1)
    line = complaint(done)
    assert line.replace(f"{mine.path}/", "").startswith(said), line


def test_a_back_end_that_does_not_work(mine, monkeypatch):
    broken = Verdict(ok=False, detail="no GPU")
    monkeypatch.setattr("simtip.render.backend.try_cuda", lambda: broken)
    mine.test("def test(simtip_pair): ...")
    done = mine.run("--simtip-backend=cuda")
    done.assert_outcomes(errors=1)
    assert complaint(done) == "CUDA does not work here: no GPU; see `simtip doctor`"


def test_the_other_tests_go_on(mine):
    mine.test(
        "def test_bad(simtip_pair):\n    simtip_pair('none.yaml')\n"
        "def test_good(simtip_pair):\n    assert simtip_pair('tiny.yaml').left.any()\n"
    )
    mine.run().assert_outcomes(failed=1, passed=1)
