"""What a baseline holds: of every condition what was found there, and all that it depends on."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from simtip.regress.sample import VIEWS, Sample
from simtip.regress.tolerance import Tolerance

FORMAT: Literal["simtip baseline"] = "simtip baseline"
VERSION: Literal[1] = 1

DIGITS = 4
"""Decimals of errors, px."""

ROUNDED = 1e-3
"""How far the length of a direction may be from 1."""

MOST_NUMBERS = 40_000
"""Errors in a file: more cannot be reviewed."""

Name = Annotated[str, Field(min_length=1, max_length=1000)]
Digest = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
Pixels = Annotated[float, Field(ge=-1e6, le=1e6)]
Error = Pixels | None
AlongAcross = Annotated[list[Pixels], Field(min_length=2, max_length=2)]
Versions = dict[str, str | None]


class Part(BaseModel):
    """Base of all parts: unknown keys are errors, values never change."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ViewResult(Part):
    """Errors in one view, px, measured - true; null where no tip was seen.

    ``bias`` and ``sd`` are along and across the needle, ``tolerance`` the least shift that counts.
    """

    axis: Annotated[list[Annotated[float, Field(ge=-1, le=1)]], Field(min_length=2, max_length=2)]
    u: list[Error]
    v: list[Error]
    bias: AlongAcross | None
    sd: AlongAcross | None
    tolerance: AlongAcross | None

    @model_validator(mode="after")
    def _is_direction(self) -> Self:
        if abs(math.hypot(*self.axis) - 1) > ROUNDED:
            raise ValueError(f"the axis {self.axis} is no direction of length 1")
        return self


class ConditionResult(Part):
    """One condition: a case at one level of its factors."""

    condition: Name
    found: Annotated[str, Field(pattern="^[01]{1,10000}$", description="1 for a tip, by trial.")]
    failed: Annotated[
        dict[str, Annotated[int, Field(ge=1)]], Field(description="Statuses without a tip.")
    ] = {}
    images: Annotated[Digest | None, Field(description="SHA-256 of all images.")]
    left: ViewResult
    right: ViewResult

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for view in VIEWS:
            one: ViewResult = getattr(self, view)
            for values in (one.u, one.v):
                if len(values) != len(self.found):
                    raise ValueError(f"{view} has {len(values)} errors of {len(self.found)} trials")
            if any((a is None) != (b is None) for a, b in zip(one.u, one.v, strict=True)):
                raise ValueError(f"{view} has a u without a v")
        return self

    @property
    def sample(self) -> Sample:
        """What was found, as arrays."""
        errors = [[one.u, one.v] for one in (self.left, self.right)]
        return Sample(
            np.array([mark == "1" for mark in self.found]),
            np.array(errors, dtype=np.float64).transpose(2, 0, 1),
            np.array([self.left.axis, self.right.axis]),
        )


class CaseResult(Part):
    """One case of the suite: what its images depend on, and its conditions."""

    case: Name
    scene: Annotated[Digest, Field(description="Of the scene without seed and detector.")]
    levels: Annotated[Digest, Field(description="Of the factors and their levels.")]
    light_seed: Annotated[int, Field(ge=0, lt=2**63)]
    noise_seed: Annotated[int, Field(ge=0, lt=2**63)]
    detector: Name
    made_with: Annotated[
        Versions | None, Field(description="If other than the baseline as a whole.")
    ] = None
    conditions: Annotated[list[ConditionResult], Field(min_length=1, max_length=10_000)]


class SuiteReference(Part):
    """Which suite, and where its file is, as seen from the baseline's folder."""

    name: Name
    file: Name
    sha256: Digest


class DetectorReference(Part):
    """Which detector; None is that of each scene. Its parameters are those given, as text."""

    name: Name | None
    parameters: dict[str, Any] = {}


class TimedCondition(Part):
    """Time of a detector for a pair of images, over that of the reference operation."""

    case: Name
    condition: Name
    ratio: Annotated[float, Field(gt=0, le=1e9)]
    scatter: Annotated[float, Field(ge=0, le=1e9, description="Standard error of its logarithm.")]


class Accepted(Part):
    """A change that was accepted."""

    case: Name
    date: Annotated[str, Field(pattern=r"^\d{4}-\d{2}-\d{2}$")]
    reason: Annotated[str, Field(min_length=1, max_length=2000)]
    changes: list[str]


class Baseline(Part):
    """All of a baseline's file but its checksum."""

    format: Literal["simtip baseline"] = FORMAT
    version: Literal[1] = VERSION
    suite: SuiteReference
    detector: DetectorReference
    seed: Annotated[
        int | None, Field(ge=0, lt=2**63, description="Of the noise, if not the suite's.")
    ] = None
    made_with: Versions
    tolerance: Tolerance
    accepted: list[Accepted] = []
    time: list[TimedCondition] = []
    cases: Annotated[list[CaseResult], Field(min_length=1, max_length=1000)]

    @model_validator(mode="after")
    def _names_once(self) -> Self:
        names = [one.case for one in self.cases]
        for case in self.cases:
            inner = [one.condition for one in case.conditions]
            if len(set(inner)) < len(inner):
                raise ValueError(f"case {case.case!r} has a condition twice")
        if len(set(names)) < len(names):
            raise ValueError("a case is there twice")
        return self

    def versions_of(self, case: CaseResult) -> Versions:
        """Give the versions that a case was made with."""
        return self.made_with if case.made_with is None else case.made_with
