"""Is the claimed covariance the scatter one observes?"""

import numpy as np
import pytest

from simtip.triangulate import METHODS, triangulate, triangulate_points

TIP_MM = np.array([-10.0, 20.0, 170.0])
LEFT_PX2 = np.array([[0.09, 0.03], [0.03, 0.04]])
RIGHT_PX2 = np.array([[0.02, -0.02], [-0.02, 0.06]])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "count"), [("svd", 40000), ("midpoint", 40000), ("optimal", 1000)]
)
def test_claimed_covariance_is_the_observed_scatter(distorted, method, count):
    """Whitened by the claim, the scatter is the identity.

    Of n samples its diagonal then has the SD sqrt(2/n) and the rest sqrt(1/n): five of these are
    allowed. Terms of second order in the noise, 0.3 px of 800 px of disparity, are far below.
    """
    left, right = distorted.project(TIP_MM)
    claim = triangulate(
        left, right, distorted, method, covariance_left_px=LEFT_PX2, covariance_right_px=RIGHT_PX2
    ).covariance_mm2
    rng = np.random.default_rng(2)
    points = triangulate_points(
        rng.multivariate_normal(left, LEFT_PX2, count),
        rng.multivariate_normal(right, RIGHT_PX2, count),
        distorted,
        method,
    )
    whiten = np.linalg.inv(np.linalg.cholesky(claim))
    scatter = np.cov(whiten @ (points - TIP_MM).T)
    limits = 5 * np.sqrt((1 + np.eye(3)) / count)
    assert (np.abs(scatter - np.eye(3)) < limits).all()


@pytest.mark.parametrize("method", METHODS)
def test_a_view_without_a_covariance_takes_sigma(table_1, method):
    pair = table_1.project(TIP_MM)
    both = triangulate(*pair, table_1, method, sigma_px=0.2).covariance_mm2
    written = triangulate(
        *pair,
        table_1,
        method,
        covariance_left_px=0.04 * np.eye(2),
        covariance_right_px=0.04 * np.eye(2),
    ).covariance_mm2
    mixed = triangulate(
        *pair, table_1, method, covariance_left_px=0.04 * np.eye(2), sigma_px=0.2
    ).covariance_mm2
    assert both == pytest.approx(written, rel=1e-12)
    assert both == pytest.approx(mixed, rel=1e-12)
    assert np.array_equal(both, both.T)
    doubled = triangulate(*pair, table_1, method, sigma_px=0.4).covariance_mm2
    assert doubled == pytest.approx(4 * both, rel=1e-12)


def test_optimal_reaches_the_bound_of_the_projections(table_1):
    """For equal isotropic noise it is the maximum-likelihood point: (J^T J)^-1 sigma^2."""
    steps = 1e-4 * np.eye(3)
    ahead, back = (np.concatenate(table_1.project(TIP_MM + s), axis=1) for s in (steps, -steps))
    J = (ahead - back).T / 2e-4
    bound = 0.3**2 * np.linalg.inv(J.T @ J)
    pair = table_1.project(TIP_MM)
    claims = {m: triangulate(*pair, table_1, m, sigma_px=0.3).covariance_mm2 for m in METHODS}
    assert claims["optimal"] == pytest.approx(bound, rel=1e-5)
    for method in ("svd", "midpoint"):
        assert np.linalg.eigvalsh(claims[method] - bound)[0] > -1e-6 * bound.max()
    assert np.trace(claims["svd"]) > 1.001 * np.trace(bound)


def test_without_pixel_noise_there_is_no_covariance(table_1):
    pair = table_1.project(TIP_MM)
    assert triangulate(*pair, table_1).covariance_mm2 is None
    one_view = triangulate(*pair, table_1, covariance_left_px=np.eye(2))
    assert one_view.ok
    assert one_view.covariance_mm2 is None


@pytest.mark.parametrize("covariance", [np.eye(3), [[1, np.nan], [0, 1]], 1.0])
def test_what_is_no_covariance_is_an_error(table_1, covariance):
    with pytest.raises(ValueError, match="2 x 2 finite numbers"):
        triangulate(*table_1.project(TIP_MM), table_1, covariance_left_px=covariance, sigma_px=1.0)
