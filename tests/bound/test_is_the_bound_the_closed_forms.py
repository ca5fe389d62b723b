"""Fisher information of known shapes, without rendering."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import special

from simtip.bound import Information, efficiency

RNG = np.random.default_rng(6)


def twice(derivatives):
    """Two replicas without noise."""
    return np.stack([derivatives, derivatives])


def test_a_gaussian_spot_in_even_noise():
    """Its place: sigma_x^2 = 2 s^2 / (pi A^2) * var * ... = var / (A^2 pi / 2) for 2-D, amplitude A
    (integral of (A x / s^2)^2 exp(-r^2 / s^2) = A^2 pi / 2)."""
    v, u = np.mgrid[-20:21, -20:21].astype(float)
    s, amplitude, variance = 2.0, 100.0, 9.0
    shape = np.exp(-(u**2 + v**2) / (2 * s**2))
    by_u, by_v, by_a = amplitude * u / s**2 * shape, amplitude * v / s**2 * shape, shape
    found = Information.from_derivatives(
        ["u", "v", "a"],
        twice(np.stack([d.ravel() for d in (by_u, by_v, by_a)])),
        np.full(u.size, 1 / variance),
    )
    expected = np.sqrt(variance / (amplitude**2 * np.pi / 2))
    np.testing.assert_allclose(found.deviations([{"u": 1.0}, {"v": 1.0}]), expected, rtol=1e-6)
    assert found.deviations({"a": 1.0}) == pytest.approx(np.sqrt(variance / (np.pi * s**2)))


def test_a_blurred_edge():
    """Place of an erf edge: information (c / s)^2 / (2 sqrt(pi)) s / var; width known or free."""
    x = np.arange(-60, 61) / 4.0
    s, contrast, variance = 1.5, 40.0, 4.0
    density = np.exp(-(x**2) / (2 * s**2)) / (s * np.sqrt(2 * np.pi))
    edge = special.ndtr(x / s)
    derivatives = np.stack([contrast * density, contrast * x / s * density, edge, np.ones_like(x)])
    found = Information.from_derivatives(
        ["place", "width", "contrast", "offset"],
        twice(derivatives),
        np.full(x.size, 0.25 / variance),
    )
    known = np.sqrt(variance * 2 * np.sqrt(np.pi) * s) / contrast
    assert found.of(["place"]).deviations({"place": 1.0}) == pytest.approx(known, rel=1e-6)
    # By symmetry the width tells nothing about the place, contrast and offset together do.
    with_width = found.of(["place", "width"]).deviations({"place": 1.0})
    assert with_width == pytest.approx(known, rel=1e-6)
    assert found.deviations({"place": 1.0}) > 1.01 * known


def test_noise_in_derivatives_adds_nothing():
    n, replicas = 4000, 4
    true = RNG.normal(size=(2, n))
    noisy = true + 2.0 * RNG.normal(size=(replicas, 2, n))
    found = Information.from_derivatives(["a", "b"], noisy, np.ones(n))
    np.testing.assert_allclose(np.diag(found.matrix), (true**2).sum(axis=1), rtol=0.1)
    np.testing.assert_allclose(np.diag(found.noise), 4.0 / replicas * n, rtol=0.1)
    naive = ((noisy.mean(axis=0)) ** 2).sum(axis=1)
    assert (naive > 1.7 * (true**2).sum(axis=1)).all()


def test_a_parameter_without_effect_is_left_out():
    true = RNG.normal(size=(2, 500))
    noise = 1e-3 * RNG.normal(size=(4, 1, 500))
    every = np.concatenate([np.tile(true, (4, 1, 1)), noise], axis=1)
    found = Information.from_derivatives(["x", "y", "roll"], every, np.ones(500))
    alone = Information.from_derivatives(["x", "y"], twice(true), np.ones(500))
    assert found.silent() == ("roll",)
    np.testing.assert_allclose(
        found.deviations([{"x": 1.0}, {"y": 1.0}]), alone.deviations([{"x": 1.0}, {"y": 1.0}])
    )
    assert found.deviations({"roll": 1.0}) == np.inf


def test_what_only_shows_in_a_sum_is_bounded_as_a_sum():
    d = RNG.normal(size=300)
    other = RNG.normal(size=300)
    found = Information.from_derivatives(
        ["x", "n", "y"], twice(np.stack([d, d, other])), np.ones(300)
    )
    assert found.deviations({"x": 1.0}) == np.inf
    assert found.deviations({"x": 1.0, "n": 1.0}) == pytest.approx(
        1 / np.sqrt((d**2).sum() * (1 - np.corrcoef(d, other)[0, 1] ** 2)), rel=0.02
    )
    assert np.isfinite(found.deviations({"y": 1.0}))


def test_two_views_add_up():
    one, other = RNG.normal(size=(2, 2, 200))
    whole = Information.from_derivatives(
        ["x", "y"], twice(np.concatenate([one, other], axis=1)), np.ones(400)
    )
    parts = [Information.from_derivatives(["x", "y"], twice(d), np.ones(200)) for d in (one, other)]
    np.testing.assert_allclose((parts[0] + parts[1]).matrix, whole.matrix)


@pytest.mark.parametrize(
    ("bound", "rmse", "expected"),
    [(1.0, 4.0, 0.25), (None, 1.0, None), (1.0, None, None), (1.0, 0.0, None), (np.inf, 1.0, None)],
)
def test_efficiency_is_bound_over_rmse(bound, rmse, expected):
    assert efficiency(bound, rmse) == expected


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="do not fit"):
        Information.from_derivatives(["a"], np.zeros((2, 2, 5)), np.ones(5))
    with pytest.raises(ValueError, match="do not fit"):
        Information.from_derivatives(["a"], np.zeros((1, 1, 5)), np.ones(5))
