"""Does the contract catch detectors with a planted fault, and only where the fault is?"""

from __future__ import annotations

from functools import cache

import bad_detectors as bad
import numpy as np
import pytest

from simtip.detect import TipObservation, contract
from simtip.detect.contract import CASES, ContractReport, Outcome
from simtip.detect.contract.drawing import Needle, coverage, disc
from simtip.detect.contract.probe import FaultError, check_answer
from simtip.errors import InputError

CAUGHT = {
    "finds a needle that points down": bad.far_off,
    "its axis points to the hub": bad.axis_to_the_tip,
    "in pictures of any shape": bad.far_off,
    "picture moved by whole pixels": bad.on_a_grid_of_two,
    "picture mirrored": bad.half_a_pixel_to_the_right,
    "contrast times 0.8 to 1.2": bad.lost_in_bright_pictures,
    "the same in 16 bits": bad.wrong_in_16_bits,
    "the same in colour": bad.wrong_in_colour,
    "two needles: one of them": bad.between_two,
    "at any angle": bad.far_off,
    "the same answer twice": bad.random,
    "any layout in memory": bad.reads_memory_as_it_lies,
    "refuses what is no image": bad.takes_anything,
    "leaves images as they are": bad.draws_on_its_input,
    **{
        case.name: bad.always_at_the_origin
        for case in CASES
        if case.name.startswith(("no tip", "needle cut off", "only its tip", "one pixel"))
    },
}

ALONE = (
    bad.axis_to_the_tip,
    bad.half_a_pixel_to_the_right,
    bad.lost_in_bright_pictures,
    bad.wrong_in_16_bits,
    bad.draws_on_its_input,
)
"""Their one fault breaks one case and no other."""


@cache
def report(function) -> ContractReport:
    detector = bad.detector(function)
    return ContractReport(detector.name, tuple(contract.run_cases(detector.configure({}))))


def broken(function):
    return {result.name for result in report(function).results if result.breaks}


def test_a_planted_fault_is_known_for_every_case():
    assert set(CAUGHT) == {case.name for case in CASES}
    assert len(CASES) == 25


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_planted_fault_fails_the_case(case):
    result = report(CAUGHT[case.name]).result(case.name)
    assert result.outcome is Outcome.FAILED
    assert result.seen
    assert result.required is case.required


@pytest.mark.parametrize("function", ALONE, ids=lambda f: f.__name__)
def test_one_fault_breaks_its_own_case_alone(function):
    assert broken(function) == {name for name, planted in CAUGHT.items() if planted is function}


def test_an_exception_breaks_every_case_required_or_not():
    everywhere = report(bad.raises)
    assert all(result.breaks for result in everywhere.results if result.name != LAST)
    assert "ZeroDivisionError on 300 x 360 px of 8 bits: division by zero" in {
        result.seen for result in everywhere.results
    }


LAST = "leaves images as they are"


@pytest.mark.parametrize(
    ("function", "said"), [(bad.gives_a_pair, "gives tuple"), (bad.outside, "outside 300 x 360 px")]
)
def test_an_answer_that_cannot_be_is_a_fault(function, said):
    result = report(function).result("finds a needle that points down")
    assert result.breaks
    assert said in result.seen


def test_a_fault_that_a_guard_reports_is_a_fault():
    image = np.zeros((4, 4), np.uint8)
    for status in ("detector_error", "command_timed_out"):
        seen = TipObservation.failed(status, "it fell over")
        with pytest.raises(FaultError, match=f"{status} .*it fell over"):
            check_answer(seen, image)


def test_what_depends_on_a_tip_is_not_applicable_without_one():
    seen = report(bad.takes_anything)
    assert seen.result("picture mirrored").outcome is Outcome.NOT_APPLICABLE
    assert not seen.ok
    assert seen.result("no tip in a black picture").outcome is Outcome.PASSED


def test_the_lines_say_what_broke_and_what_is_merely_not_so():
    lines = contract.report_lines(report(bad.half_a_pixel_to_the_right))
    assert len(lines) == len(CASES) + 1
    assert [line for line in lines if line.startswith("FAILED")] == [
        "FAILED  picture mirrored                  1.00 px apart at worst, 1.00 px on the mean"
    ]
    assert any(line.startswith("no      at any angle") for line in lines)
    assert lines[-1] == "half_a_pixel_to_the_right fails 1 of 21 required cases"
    assert all("\n" not in line for line in lines)


def test_pictures_cover_the_area_that_is_stated():
    covered = coverage((50, 50), disc((20.3, 21.7), 9.2))
    assert covered.sum() == pytest.approx(16 * np.sin(np.pi / 16) * 9.2**2, rel=1e-4)
    v, u = np.mgrid[:50, :50]
    centre = [(covered * u).sum() / covered.sum(), (covered * v).sum() / covered.sum()]
    assert centre == pytest.approx([20.3, 21.7], abs=1e-3)
    needle = Needle((30.25, 40.5), width_px=8, point_px=16)
    shaft = coverage((60, 60), needle.outline)[10]
    assert shaft.sum() == pytest.approx(8, abs=1e-9)
    assert (shaft @ np.arange(60)) / 8 == pytest.approx(30.25, abs=1e-9)
    assert coverage((60, 60), needle.outline)[41:].sum() == 0


# --- in a process of its own ----------------------------------------------------------------


@pytest.mark.slow
def test_a_hang_is_a_failed_case_and_the_others_still_run():
    seen = contract.check(bad.detector(bad.hangs_on_white), limit_s=2)
    assert [(r.name, r.seen) for r in seen.results if r.breaks] == [
        ("no tip in a saturated picture", "no answer within 2 s"),
        ("one pixel, one row, one column", "no answer within 2 s"),
    ]
    assert len(seen.results) == len(CASES)
    assert seen.results[-1].outcome is Outcome.NOT_APPLICABLE
    assert "not tried" in seen.results[-1].seen


@pytest.mark.slow
def test_a_process_that_dies_is_a_failed_case():
    seen = contract.check(bad.detector(bad.dies_on_colour))
    assert seen.result("the same in colour").seen == "its process ended with exit code 3"
    assert seen.result("needle cut off at the left").outcome is Outcome.PASSED


@pytest.mark.slow
def test_in_its_own_process_the_report_is_the_same_and_stdout_stays_clean(capfd):
    seen = contract.check(bad.detector(bad.chats))
    assert seen.results == report(bad.chats).results
    capfd.readouterr()
    assert contract.check(bad.detector(bad.chats)).ok
    assert capfd.readouterr().out == ""


def test_what_cannot_be_sent_is_one_line():
    with pytest.raises(InputError, match=r"^the detector <lambda> cannot be sent .*give its name"):
        contract.check(bad.detector(lambda _image, _p, **_layers: bad.NO_TIP))


@pytest.mark.slow
def test_bad_names_and_values_are_input_errors():
    with pytest.raises(InputError, match="did you mean 'lin2020'"):
        contract.check("lin2002")
    with pytest.raises(InputError, match=r"detect\.threshold"):
        contract.check("lin2020", {"threshold": 999})
