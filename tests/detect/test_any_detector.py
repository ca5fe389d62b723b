"""Does every registered detector keep the contract, and declare its parameters?"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from simtip import detect
from simtip.detect import contract

NAMES = detect.names()

NOT_ABLE = {"lin2020": {"at any angle", "no tip in a disc or a cable"}, "subpixel": set()}
"""What is not required and what a detector cannot do today; another name here needs a reason."""


@cache
def report(name):
    return contract.ContractReport(name, tuple(contract.run_cases(detect.configure(name))))


SLOW = {"subpixel"}


@pytest.fixture(params=[pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in NAMES])
def name(request):
    return request.param


@pytest.mark.parametrize("case", contract.CASES, ids=lambda case: case.name)
def test_it_keeps_the_contract(name, case):
    result = report(name).result(case.name)
    assert result.name in NOT_ABLE[name] or result.outcome is contract.Outcome.PASSED, result.seen


def test_it_can_do_no_more_than_is_known(name):
    failed = {r.name for r in report(name).results if r.outcome is contract.Outcome.FAILED}
    assert failed == NOT_ABLE[name]
    assert report(name).ok


def test_its_parameters_are_declared_and_their_defaults_are_accepted(name):
    declared = detect.parameters_of(name)
    assert declared
    for parameter in declared:
        assert parameter.description
        assert parameter.type
    values = {p.name: p.default for p in declared}
    as_text = {
        n: ",".join(map(str, v)) if isinstance(v, tuple) else str(v) for n, v in values.items()
    }
    tips = [detect.configure(name, v)(needle()).tip_px.tolist() for v in ({}, values, as_text)]
    assert tips[0] == tips[1] == tips[2]


def test_calling_it_is_configuring_and_running_it(name):
    detector = detect.get(name)
    assert detector.name == name
    assert detector.summary
    observation = detector(needle(), layers=True)
    assert observation.layers
    assert observation.tip_px.tolist() == detect.configure(name)(needle()).tip_px.tolist()


def needle():
    image = np.full((400, 300), 180, np.uint8)
    image[0:300, 100:121] = 40
    return image
