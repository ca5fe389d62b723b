"""Does an interferometer read what its errors say? Each against its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from simtip.experiment.interferometer import readings
from simtip.spec.experiment import InterferometerSpec

PLACES = np.tile(np.arange(0, 30, 2.0), (4000, 1))
NONE = {"accuracy_ppm": 0.0, "resolution_mm": 0.0}


def read(places=PLACES, **errors):
    spec = InterferometerSpec(**{**NONE, **errors})
    return readings(spec, places, np.random.default_rng(3))


def test_without_errors_it_reads_the_carriage():
    assert (read() == PLACES).all()


def test_it_rounds_to_its_resolution():
    read_ = read(PLACES[:1] + 0.123456, resolution_mm=0.01)
    assert read_[0, 0] == pytest.approx(0.12)


def test_a_slanted_beam_reads_the_cosine():
    assert read(misalignment_mrad=10.0)[0, -1] == pytest.approx(28 * np.cos(0.01), abs=1e-12)


def test_the_scale_error_holds_95_percent_of_runs_and_is_one_a_run():
    scale = read(accuracy_ppm=0.5)[:, 1:] / PLACES[:, 1:] - 1
    assert np.ptp(scale, axis=1).max() < 1e-12
    inside = np.mean(np.abs(scale[:, 0]) < 0.5e-6)
    assert inside == pytest.approx(0.95, abs=0.012)


def test_air_over_the_dead_path_adds_what_it_delays():
    off = read(dead_path_mm=1000.0, air_drift_ppm=1.0) - PLACES
    assert off.std() == pytest.approx(1e-3, rel=0.02)
    assert abs(off.mean()) < 1e-4


def test_the_renishaw_is_good_to_nanometres_over_28_mm():
    off = readings(InterferometerSpec(), PLACES, np.random.default_rng(0)) - PLACES
    assert np.abs(off).max() < 28 * 0.5e-6 * 2.5 + 0.5e-6
