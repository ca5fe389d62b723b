from __future__ import annotations

import re
import xml.etree.ElementTree as ET  # of a file that the test itself has made

import numpy as np
import pytest

from simtip.image_file import read_image

NEAR = "simtip_pair('tiny.yaml', 1).assert_tip_within(lowest_dark, px=9, mm=1)"
TOO_NEAR = "simtip_pair('tiny.yaml', 1).assert_tip_within(lowest_dark, px=0.1)"


def bluer(picture) -> int:
    """Count pixels that are blue on a gray picture: the true tip's mark."""
    red, _, blue = np.moveaxis(picture.astype(int), -1, 0)
    return int((blue - red > 50).sum())


def redder(picture) -> int:
    """Count pixels that are vermilion: the detected tip's."""
    red, _, blue = np.moveaxis(picture.astype(int), -1, 0)
    return int((red - blue > 80).sum())


def test_nothing_is_written_when_tests_pass(mine):
    mine.test(f"def test(simtip_pair):\n    {NEAR}")
    mine.run().assert_outcomes(passed=1)
    assert not (mine.path / ".simtip-failures").exists()


def test_the_words_are_in_the_report_and_point_at_the_tests_own_line(mine):
    mine.test(f"def test(simtip_pair):\n    {TOO_NEAR}")
    done = mine.run()
    done.assert_outcomes(failed=1)
    said = done.stdout.str()
    done.stdout.fnmatch_lines(
        [
            f">       {TOO_NEAR}",
            "E       AssertionError: tiny, seed 1: the tip is not within 0.1 px",
            "E         left: * px off, along +* (short of the tip), across *; found at (*",
            "E         right: * px off, *",
            "test_mine.py:5: AssertionError",
            "*simtip: true and detected tips*",
            "tiny, seed 1: .simtip-failures/test_mine.py/test/01_tiny_seed_1.png",
        ]
    )
    assert "pair.py" not in said
    assert "limits.py" not in said


def test_the_picture_shows_the_true_and_the_detected_tip(mine):
    mine.test(
        f"def test(simtip_pair):\n    {TOO_NEAR}\n"
        "def test_own(simtip_pair):\n"
        "    pair = simtip_pair('tiny.yaml', 1)\n"
        "    assert pair.left.mean() < 1\n"
    )
    mine.run().assert_outcomes(failed=2)
    base = mine.path / ".simtip-failures" / "test_mine.py"
    whole = read_image(base / "test" / "01_tiny_seed_1.png")
    assert bluer(whole) > 20
    assert redder(whole) > 20
    assert whole.shape[0] == 150
    assert whole.shape[1] in range(201, 210)
    bare = read_image(base / "test_own" / "01_tiny_seed_1.png")
    assert bluer(bare) > 20
    assert redder(bare) == 0


def test_those_that_failed_are_drawn_or_else_the_last(mine):
    marked = "@pytest.mark.simtip(suite='suite.yaml', cases=['nominal'], repeats=11)"
    mine.test(
        f"{marked}\n"
        "def test_all(simtip_suite):\n"
        "    simtip_suite.assert_tips_within(lowest_dark, px=0.1)\n"
        f"{marked}\n"
        "def test_one(simtip_suite):\n"
        "    for pair in simtip_suite:\n"
        "        if pair.repeat == 5:\n"
        "            with pytest.raises(AssertionError, match='not within 0.1 px'):\n"
        "                pair.assert_tip_within(lowest_dark, px=0.1)\n"
        "    assert False\n"
        f"{marked}\n"
        "def test_none(simtip_suite):\n"
        "    assert not list(simtip_suite)\n"
    )
    done = mine.run()
    done.assert_outcomes(failed=3)
    names = {}
    for one in mine.pictures():
        _, test, name = one.split("/")
        names.setdefault(test, []).append(name)
    assert names == {
        "test_all-nominal": [f"{k:02d}_nominal_repeat_{k}.png" for k in range(1, 9)],
        "test_one-nominal": ["01_nominal_repeat_6.png"],
        "test_none-nominal": [f"{k:02d}_nominal_repeat_{k + 3}.png" for k in range(1, 9)],
    }
    said = done.stdout.str()
    assert said.count("and 3 more, of which there is no picture") == 1
    assert "nominal: 11 of 11 tips are not within 0.1 px" in said
    assert "  and 1 more\n" in said


def test_a_share_of_a_case_may_fail(mine):
    """Of three pairs the detector sees two: 2/3 is enough, 0.67 is not."""
    body = "\n".join(
        f"@pytest.mark.simtip(suite='suite.yaml', cases=['nominal'])\n"
        f"def test_{name}(simtip_suite):\n"
        "    calls = iter(range(100))\n"
        "    def forgetful(image):\n"
        "        return None if next(calls) == 2 else lowest_dark(image)\n"
        f"    simtip_suite.assert_tips_within(forgetful, px=9{share})"
        for name, share in (("all", ""), ("most", ", share=0.67"), ("some", ", share=2 / 3"))
    )
    mine.test(body)
    done = mine.run()
    done.assert_outcomes(passed=1, failed=2)
    said = done.stdout.str()
    assert "nominal: 1 of 3 tips are not within 9 px\n" in said
    assert "nominal: 1 of 3 tips are not within 9 px (67% have to be)\n" in said
    assert "left: no tip found (the detector found no tip)" in said
    assert len(mine.pictures()) == 2


def test_a_case_without_a_tip_in_view_wants_none(mine):
    """In the right view of `away` the true tip is below the image, the needle's shaft in it."""
    mine.test(
        "def in_left(image):\n"
        "    return None if image[-1].min() < 100 else lowest_dark(image)\n"
        "@pytest.mark.simtip(suite='suite.yaml', cases=['away'], repeats=1)\n"
        "def test_good(simtip_suite):\n"
        "    simtip_suite.assert_tips_within(in_left, px=9, mm=1)\n"
        "@pytest.mark.simtip(suite='suite.yaml', cases=['away'], repeats=1)\n"
        "def test_bad(simtip_suite):\n"
        "    simtip_suite.assert_tips_within(lowest_dark, px=9, mm=1)\n"
    )
    done = mine.run()
    done.assert_outcomes(passed=1, failed=1)
    done.stdout.fnmatch_lines(
        ["E*right: a tip found at (*, *); the true one, (*, *), is outside the image"]
    )


def test_a_function_that_raises_is_shown_where_it_does(mine):
    mine.test(
        "def bad(image):\n"
        "    return image[10**6]\n"
        "def test(simtip_pair):\n"
        "    simtip_pair('tiny.yaml').measure(bad)\n"
    )
    done = mine.run()
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(
        [">       simtip_pair('tiny.yaml').measure(bad)", ">       return image[[]10[*][*]6[]]"]
    )
    said = done.stdout.str()
    assert "test_mine.py:5: IndexError" in said
    assert "simtip/measure.py" not in said
    assert "During handling" not in said


def test_what_an_exception_came_of_is_shown_too(mine):
    mine.test(
        "def bad(image):\n"
        "    try:\n"
        "        {}['threshold']\n"
        "    except KeyError:\n"
        "        raise ValueError('no threshold')\n"
        "def test(simtip_pair):\n"
        "    simtip_pair('tiny.yaml').measure(bad)\n"
    )
    said = mine.run().stdout.str()
    assert "KeyError: 'threshold'" in said
    assert "During handling of the above exception" in said
    assert "ValueError: no threshold" in said
    assert "simtip/measure.py" not in said


def test_a_function_that_ends_the_program_is_shown_where_it_does(mine):
    mine.test(
        "def bad(image):\n    raise SystemExit(3)\n"
        "def test(simtip_pair):\n    simtip_pair('tiny.yaml').measure(bad)\n"
    )
    done = mine.run()
    done.assert_outcomes(failed=1)
    said = done.stdout.str()
    assert "test_mine.py:5: SystemExit" in said
    assert "simtip/measure.py" not in said


def test_a_measurement_that_failed_says_why_wherever_it_is_shown(mine):
    mine.test("def test(simtip_pair):\n    assert simtip_pair('tiny.yaml').measure('os:system').ok")
    said = mine.run().stdout.str()
    assert "<tiny: left_detector_error (left: TypeError: " in said


def test_images_cannot_be_changed_by_a_detector(mine):
    mine.test(
        "def vandal(image):\n"
        "    image[:] = 0\n"
        "def test(simtip_pair):\n"
        "    with pytest.raises(ValueError, match='read-only'):\n"
        "        simtip_pair('tiny.yaml').measure(vandal)\n"
    )
    mine.run().assert_outcomes(passed=1)


def test_the_folder_may_be_named_and_is_else_kept_from_git(mine):
    mine.test(f"def test(simtip_pair):\n    {TOO_NEAR}")
    mine.run().assert_outcomes(failed=1)
    assert (mine.path / ".simtip-failures" / ".gitignore").read_text() == "*\n"
    mine.run("--simtip-artifacts=out/pictures").assert_outcomes(failed=1)
    assert mine.pictures("out/pictures") == ["test_mine.py/test/01_tiny_seed_1.png"]
    assert not (mine.path / "out/pictures/.gitignore").exists()


def test_pictures_of_an_earlier_failure_go_when_the_test_runs_again(mine):
    mine.test(f"def test(simtip_pair):\n    {TOO_NEAR}\ndef test_b(simtip_pair):\n    {TOO_NEAR}")
    mine.run().assert_outcomes(failed=2)
    own = mine.write(".simtip-failures/test_mine.py/test/notes.txt", "the user's own")
    assert len(mine.pictures()) == 2
    mine.test(f"def test(simtip_pair):\n    {NEAR}\ndef test_b(simtip_pair):\n    {TOO_NEAR}")
    mine.run("-k", "test_b").assert_outcomes(failed=1, deselected=1)
    assert len(mine.pictures()) == 2
    mine.run().assert_outcomes(passed=1, failed=1)
    assert mine.pictures() == ["test_mine.py/test_b/01_tiny_seed_1.png"]
    assert own.exists()


def test_tests_whose_names_differ_in_signs_have_folders_of_their_own(mine):
    mine.test(
        "@pytest.mark.parametrize('x', ['a b', 'a/b', 'a_b', '../../..', 'x' * 200, 'x' * 201])\n"
        f"def test(simtip_pair, x):\n    {TOO_NEAR}"
    )
    mine.run().assert_outcomes(failed=6)
    folders = {one.rsplit("/", 1)[0] for one in mine.pictures()}
    assert len(folders) == 6
    assert all(folder.startswith("test_mine.py/test-") for folder in folders)


def test_parameters_that_read_alike_have_folders_of_their_own(mine):
    mine.test(
        "@pytest.mark.parametrize('x', ['a::b', 'a-b', 'a[b', 'a]b'])\n"
        f"def test(simtip_pair, x):\n    {TOO_NEAR}"
    )
    mine.run().assert_outcomes(failed=4)
    assert len(mine.pictures()) == 4


def test_files_whose_folders_differ_in_signs_have_folders_of_their_own(mine):
    body = f"def test(simtip_pair):\n    {TOO_NEAR}"
    for folder in ("a b", "a_b", "a[b", "x" * 90, "x" * 91):
        mine.test(body, f"{folder}/test_it.py")
    mine.run("--import-mode=importlib", "-o", "pythonpath=.").assert_outcomes(failed=5)
    assert len(mine.pictures()) == 5


def test_files_outside_the_root_folder_have_folders_of_their_own(mine):
    for folder in ("a", "b"):
        mine.test(f"def test(simtip_pair):\n    {TOO_NEAR}", f"{folder}/test_{folder}.py")
        mine.write(f"{folder}/tiny.yaml", (mine.path / "tiny.yaml").read_text())
    (mine.path / "root").mkdir()
    tests = [mine.path / "a", mine.path / "b"]
    words = ["--rootdir=root", "-c", "/dev/null", "--import-mode=importlib"]
    mine.pytester.syspathinsert(mine.path)
    mine.run(*words, *tests).assert_outcomes(failed=2)
    found = [one.split("/") for one in mine.pictures("root/.simtip-failures")]
    # The first part is a digest of where the folder lies.
    assert sorted(parts[1:] for parts in found) == [
        [f"test_{folder}.py", "test", "01_tiny_seed_1.png"] for folder in "ab"
    ]
    assert found[0][0] != found[1][0]


def test_what_cannot_be_written_is_said_and_changes_no_result(mine):
    mine.test(f"def test(simtip_pair):\n    {TOO_NEAR}")
    mine.write("out", "a file where the folder should be")
    done = mine.run("--simtip-artifacts=out")
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["no picture: *"])
    assert "INTERNALERROR" not in done.stdout.str()


def test_a_folder_of_too_long_a_name_is_said_and_changes_no_result(mine):
    mine.test(f"def test(simtip_pair):\n    {TOO_NEAR}\ndef test_good(simtip_pair):\n    {NEAR}")
    done = mine.run(f"--simtip-artifacts={'x' * 300}")
    done.assert_outcomes(failed=1, passed=1)
    done.stdout.fnmatch_lines(["no picture: *File name too long*"])


def test_a_failure_that_is_expected_needs_no_picture(mine):
    mine.test(f"@pytest.mark.xfail\ndef test(simtip_pair):\n    {TOO_NEAR}")
    mine.run().assert_outcomes(xfailed=1)
    assert mine.pictures() == []


def test_a_failure_in_a_fixture_is_shown_too(mine):
    mine.test(
        f"@pytest.fixture\ndef pair(simtip_pair):\n    return {TOO_NEAR}\ndef test(pair): ..."
    )
    mine.run().assert_outcomes(errors=1)
    assert mine.pictures() == ["test_mine.py/test/01_tiny_seed_1.png"]


def test_junit_xml_names_the_pictures(mine):
    mine.test(f"def test(simtip_pair):\n    {TOO_NEAR}\ndef test_good(simtip_pair):\n    {NEAR}")
    mine.run("--junitxml=report.xml").assert_outcomes(failed=1, passed=1)
    root = ET.parse(mine.path / "report.xml").getroot()  # noqa: S314 (see above)
    found = {
        case.get("name"): [(p.get("name"), p.get("value")) for p in case.iter("property")]
        for case in root.iter("testcase")
    }
    path = mine.path / ".simtip-failures/test_mine.py/test/01_tiny_seed_1.png"
    assert found == {"test": [("simtip_picture", str(path))], "test_good": []}


def test_the_report_of_the_call_names_them_too(mine):
    """Other plug-ins read that one; JUnit's XML is made of what the test itself has at its end."""
    mine.write(
        "conftest.py",
        "def pytest_runtest_logreport(report):\n"
        "    for name, value in report.user_properties:\n"
        "        print(report.when, name, value)\n",
    )
    mine.test(f"def test(simtip_pair):\n    {TOO_NEAR}")
    done = mine.run("-s")
    told = re.findall(r"(setup|call|teardown) simtip_picture", done.stdout.str())
    assert told == ["call", "teardown"]


def test_pytest_html_shows_the_pictures(mine):
    pytest.importorskip("pytest_html", reason="comes with the test dependencies")
    mine.test(f"def test(simtip_pair):\n    {TOO_NEAR}\ndef test_good(simtip_pair):\n    {NEAR}")
    done = mine.run("--html=report.html", "--self-contained-html", others=True)
    done.assert_outcomes(failed=1, passed=1)
    page = (mine.path / "report.html").read_text()
    assert page.count("data:image/png;base64,") == 1


@pytest.mark.slow
def test_workers_of_xdist_report_the_same(mine):
    mine.test(
        "@pytest.mark.parametrize('k', range(4))\n"
        f"def test(simtip_pair, k):\n    {TOO_NEAR}\n"
        "@pytest.mark.simtip(suite='suite.yaml', repeats=1)\n"
        "def test_cases(simtip_suite):\n    list(simtip_suite)\n"
    )
    done = mine.in_a_process("-n", "2", "--junitxml=report.xml", "-W", "error")
    done.assert_outcomes(failed=4, passed=4)
    assert len(mine.pictures()) == 4
    assert done.stdout.str().count("simtip: true and detected tips") == 4
    assert (mine.path / "report.xml").read_text().count('name="simtip_picture"') == 4
