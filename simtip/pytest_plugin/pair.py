"""What a test is given: a pair of images, what is true of it, and what measures on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from simtip.measure import Measurement
from simtip.pytest_plugin.limits import Limits
from simtip.pytest_plugin.one_line import in_one_line
from simtip.pytest_plugin.under_test import beyond_simtip, under_test
from simtip.score import TipError
from simtip.trial import measured

if TYPE_CHECKING:
    from simtip.camera import StereoRig
    from simtip.pytest_plugin.used import Used
    from simtip.sensor import Image
    from simtip.spec import SceneSpec
    from simtip.sweep.shots import Shot
    from simtip.sweep.stages import Setting
    from simtip.truth import SceneTruth


@dataclass(frozen=True, eq=False)
class Pair:
    """A simulated pair of images and what is true of it.

    Attributes
    ----------
    name
        For messages and pictures.
    scene
        What was simulated.
    setting, shot
        What is true of it, and its images, as sweeps have them.
    used
        Of the test that it was made for.
    condition
        Of a case of a suite, the fields that vary in it, with their values here.
    repeat
        0, 1, ... of pairs that differ in their noise only.
    """

    name: str
    scene: SceneSpec = field(repr=False)
    setting: Setting = field(repr=False)
    shot: Shot = field(repr=False)
    used: Used = field(repr=False)
    condition: Mapping[str, Any] = field(default_factory=dict, repr=False)
    repeat: int = field(default=0, repr=False)

    @property
    def left(self) -> Image:
        """The left image, (H, W, 3) RGB, DN; uint8 at 8 bit, uint16 above. It cannot be changed."""
        return self.shot.images[0]

    @property
    def right(self) -> Image:
        """The right image."""
        return self.shot.images[1]

    @property
    def truth(self) -> SceneTruth:
        """Where the tip is: ``tip_mm``, ``axis``, ``left.tip_px``, ``right.tip_px`` and more."""
        return self.setting.truth

    @property
    def rig(self) -> StereoRig:
        """The cameras, as who measures knows them: the true ones, or the scene's calibration."""
        return self.setting.rig

    @property
    def exposure_s(self) -> float:
        """The exposure time, s, as auto-exposure has settled it."""
        return float(self.shot.exposure_s)

    @property
    def noise_seed(self) -> int:
        """Of the sensors' noise: `simtip remix --seed` makes the images again."""
        return self.setting.seed

    @property
    def tip_in_images(self) -> bool:
        """Whether the true tip lies in both images, hidden or not."""
        truth = self.truth
        cameras = (truth.rig.left, truth.rig.right)
        views = (truth.left, truth.right)
        return all(
            bool(camera.contains(view.tip_px)) for camera, view in zip(cameras, views, strict=True)
        )

    def measure(self, detector: object = None, **settings: object) -> MeasuredPair:
        """Measure the tip as `simtip run` does, and compare it with the truth.

        What a function under test raises, the test gets.

        Parameters
        ----------
        detector
            A function of an image, see docs/your_detector.md for what it may give; or what names a
            detector, as ``--detector`` does; by default the scene's own.
        settings
            Its parameters.
        """
        __tracebackhide__ = True
        try:
            with in_one_line():
                measurement, error = measured(
                    self.shot.images,
                    self.truth,
                    self.scene,
                    under_test(detector, settings, self.scene),
                    rig=self.rig,
                    refiner=self.setting.refiner,
                )
        except BaseException as raised:
            # Where none of it is the test's, it is a fault of simtip's own.
            raised.__traceback__ = beyond_simtip(raised.__traceback__) or raised.__traceback__
            raise
        self.used.note(self, measurement)
        return MeasuredPair(self, measurement, error)

    def assert_tip_within(
        self,
        detector: object = None,
        *,
        px: float | None = None,
        along_px: float | None = None,
        across_px: float | None = None,
        mm: float | None = None,
    ) -> MeasuredPair:
        """Measure the tip, and assert that it is where it should be.

        Parameters
        ----------
        detector
            See `measure`.
        px, along_px, across_px, mm
            See `MeasuredPair.assert_within`.
        """
        __tracebackhide__ = True
        done = self.measure(detector)
        done.assert_within(px=px, along_px=along_px, across_px=across_px, mm=mm)
        return done


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredPair:
    """What was measured on a pair, and how wrong that is.

    Attributes
    ----------
    pair
        The pair.
    measurement
        What was seen in both images, and the tip in space.
    error
        Measured - true: ``left`` and ``right`` with ``u_px``, ``v_px``, ``along_px``,
        ``across_px`` and ``norm_px``, ``point`` with ``x_mm``, ``y_mm``, ``z_mm`` and ``norm_mm``;
        None of what was not found.
    """

    pair: Pair
    measurement: Measurement
    error: TipError

    def __repr__(self) -> str:
        """Say in a failed assertion what was wrong."""
        why = f" ({self.reason})" if self.reason else ""
        return f"<{self.pair.name}: {self.status}{why}>"

    @property
    def ok(self) -> bool:
        """Whether a tip was measured in space."""
        return self.measurement.status == "ok"

    @property
    def status(self) -> str:
        """``ok`` or the code of the first thing that failed."""
        return self.measurement.status

    @property
    def reason(self) -> str:
        """What failed, in a sentence; empty if nothing did."""
        return self.measurement.reason

    def assert_within(
        self,
        *,
        px: float | None = None,
        along_px: float | None = None,
        across_px: float | None = None,
        mm: float | None = None,
    ) -> None:
        """Assert that the tip is where it should be; give at least one limit.

        Where the true tip lies outside an image, no tip may be found in it, and `mm` does not
        count.

        Parameters
        ----------
        px
            Largest error in each image, px.
        along_px, across_px
            Largest error along and across the needle's axis in each image, px.
        mm
            Largest error in space, mm.
        """
        __tracebackhide__ = True
        with in_one_line():
            limits = Limits(px, along_px, across_px, mm)
        said = limits.complaints(self)
        if said:
            self.pair.used.note_failure(self.pair, self.measurement)
            lines = "".join(f"\n  {line}" for line in said)
            raise AssertionError(f"{self.pair.name}: the tip is not within {limits}{lines}")
