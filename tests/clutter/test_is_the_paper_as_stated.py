"""Has the paper the contrast, scale, gradient and slope that the scene states, and its albedo?"""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError
from scipy import ndimage

from simtip.clutter import board_texture
from simtip.spec.background import BackgroundSpec, Gradient, PaperTexture, Wrinkles
from simtip.spec.clutter import ClutterSpec

LOW, HIGH = (-60.0, -50.0), (60.0, 50.0)
NONE = ClutterSpec()


def made(low=LOW, high=HIGH, step_mm=0.1, **background):
    return board_texture(BackgroundSpec(**background), NONE, 5, low, high, step_mm=step_mm)


def autocorrelation(values, lag):
    v = values - values.mean()
    return float((v[:, lag:] * v[:, :-lag]).mean() / (v**2).mean())


@pytest.mark.parametrize("length", [0.4, 1.3])
def test_grain_has_its_contrast_and_correlation_length(length):
    """Texels average over their area: variance falls by 1 / (1 + step^2 / 3 L^2)."""
    paper = PaperTexture(contrast=0.03, correlation_mm=length, mottle_contrast=0)
    albedo = made(paper=paper).albedo.astype(float)
    widened = 1 + 0.1**2 / (3 * length**2)
    assert albedo.std() == pytest.approx(0.03 / widened, rel=0.02)
    lag = round(length / 0.1)
    assert autocorrelation(albedo, lag) == pytest.approx(np.exp(-1 / widened), abs=0.02)
    assert autocorrelation(albedo.T, lag) == pytest.approx(np.exp(-1 / widened), abs=0.02)


def test_grain_is_as_strong_between_the_noises_lattice_as_on_it():
    paper = PaperTexture(contrast=0.03, correlation_mm=0.8, mottle_contrast=0)
    texture = made(paper=paper)
    columns = np.arange(texture.albedo.shape[1]) + round(texture.corner_mm[0] / 0.1)
    spread = [texture.albedo[:, columns % 4 == k].std() for k in range(4)]  # the lattice: 0.4 mm
    assert max(spread) / min(spread) < 1.02


def test_coarser_texels_are_the_mean_of_finer_ones():
    paper = PaperTexture(contrast=0.03, correlation_mm=0.5, mottle_contrast=0)
    fine = made(low=(-20, -20), high=(20, 20), paper=paper)
    coarse = made(low=(-10, -10), high=(10, 10), paper=paper, step_mm=0.3)
    mean = ndimage.uniform_filter(fine.albedo.astype(float), 3)
    i, j = np.rint((coarse.corner_mm - fine.corner_mm) / 0.1).astype(int)
    rows, cols = coarse.albedo.shape
    same = mean[j : j + 3 * rows : 3, i : i + 3 * cols : 3]
    assert np.abs(coarse.albedo - same).std() < 0.05 * same.std()


@pytest.mark.parametrize(
    "texture",
    [
        {"paper": PaperTexture(contrast=0.05, mottle_contrast=0.01, mottle_mm=1.0)},
        {"gradient": Gradient(ratio=0.5, direction_deg=37)},
        {"gradient": Gradient(ratio=0.3, direction_deg=-70, span_mm=60)},
        {"gradient": Gradient(kind="vignette", ratio=0.4)},
        {"paper": PaperTexture(contrast=0.04), "gradient": Gradient(ratio=0.7)},
    ],
)
def test_the_mean_albedo_over_the_board_stays_as_stated(texture):
    albedo = made(size_mm=(120, 100), albedo=(0.5, 0.5, 0.5), **texture).albedo.astype(float)
    # The outermost texels reach over the edge by half: the trapezoidal mean is the board's.
    mean = np.trapezoid(np.trapezoid(albedo, axis=0), axis=0) / np.prod(np.array(albedo.shape) - 1)
    assert mean == pytest.approx(1, abs=2e-3)


def test_white_paper_never_reflects_more_than_it_gets_and_keeps_its_mean():
    paper = PaperTexture(contrast=0.036, mottle_contrast=0)
    albedo = made(albedo=(0.9, 0.9, 0.9), paper=paper).albedo.astype(float)
    gray = made(albedo=(0.5, 0.5, 0.5), paper=paper).albedo.astype(float)
    assert albedo.max() * 0.9 == pytest.approx(1, abs=1e-6), "the grain never met the limit"
    assert albedo.max() * 0.9 <= 1 + 1e-6
    assert gray.max() * 0.9 > 1
    assert albedo.mean() == pytest.approx(gray.mean(), abs=2e-5)


def at(texture, s, t):
    i, j = np.rint((np.array([s, t]) - texture.corner_mm) / texture.step_mm).astype(int)
    return float(texture.albedo[j, i])


def test_a_linear_gradient_has_its_ratio_and_direction():
    texture = made(size_mm=(120, 100), gradient=Gradient(ratio=0.6, direction_deg=0))
    assert at(texture, 60, 0) / at(texture, -60, 0) == pytest.approx(0.6, rel=1e-3)
    assert at(texture, 0, 50) == pytest.approx(at(texture, 0, -50), rel=1e-6)
    texture = made(size_mm=(120, 100), gradient=Gradient(ratio=0.6, direction_deg=90, span_mm=40))
    assert at(texture, 0, 20) / at(texture, 0, -20) == pytest.approx(0.6, rel=1e-3)
    assert at(texture, 0, 48) == at(texture, 0, 20)


def test_a_vignette_has_its_ratio():
    texture = made(size_mm=(120, 100), gradient=Gradient(kind="vignette", ratio=0.6))
    assert at(texture, 60, 50) / at(texture, 0, 0) == pytest.approx(0.6, rel=1e-3)


def turns(texture):
    """Curl of the slope over its largest derivative: a height's slope has none."""
    slope, step = texture.slope.astype(float), texture.slope_step_mm
    ds_dt = np.gradient(slope[..., 0], step, axis=0)[1:-1, 1:-1]
    dt_ds = np.gradient(slope[..., 1], step, axis=1)[1:-1, 1:-1]
    return np.abs(ds_dt - dt_ds).max() / max(np.abs(ds_dt).max(), np.abs(dt_ds).max())


def test_wrinkles_have_their_slope_and_are_the_slope_of_a_height():
    wrinkles = Wrinkles(rms_slope=0.08, scale_mm=8)
    texture = made(low=(-200, -200), high=(200, 200), wrinkles=wrinkles)
    slope, step = texture.slope.astype(float), texture.slope_step_mm
    assert np.sqrt((slope**2).sum(axis=-1).mean()) == pytest.approx(0.08, rel=0.05)
    assert turns(texture) < 0.02
    # Its correlation length, by the curvature.
    curvature = np.gradient(slope[..., 0], step, axis=1)
    ratio = (curvature**2).mean() / (slope[..., 0] ** 2).mean()
    assert ratio == pytest.approx(6 / 8**2, rel=0.1)  # of exp(-(d/L)^2): (12 / L^4) / (2 / L^2)


def test_a_fold_is_a_straight_crease_of_its_slope():
    wrinkles = Wrinkles(rms_slope=0, folds=1, fold_slope=0.2)
    texture = made(size_mm=(120, 100), wrinkles=wrinkles)
    slope = texture.slope.astype(float)
    assert turns(texture) < 0.2  # by differences over half the width of the crease
    steep = np.linalg.norm(slope, axis=-1)
    assert steep.max() == pytest.approx(0.2, rel=0.15)
    assert np.linalg.matrix_rank(slope.reshape(-1, 2), tol=1e-3) == 1
    along = slope[..., np.abs(slope).sum(axis=(0, 1)).argmax()]
    assert along.max() > 0.15
    assert along.min() < -0.15


def test_a_flat_and_even_board_costs_nothing():
    assert made() is None
    assert made(low=(500, 500), high=(600, 600), paper=PaperTexture()) is None, "beside the board"
    assert made(paper=PaperTexture()).slope is None
    assert made(gradient=Gradient()).albedo.size < 10_000


@pytest.mark.parametrize(
    "wrong",
    [
        {"albedo": (0.95, 0.9, 0.9), "paper": {"contrast": 0.1}},
        {"albedo": (0.8, 0.8, 0.8), "gradient": {"ratio": 0.1}},
        {"gradient": {"kind": "vignette", "span_mm": 100}},
        {"paper": {"correlation_mm": 0.01}},
        {"paper": {"contrast": -0.1}},
        {"wrinkles": {"rms_slope": 3}},
        {"texture": {}},
    ],
)
def test_what_cannot_be_is_refused(wrong):
    with pytest.raises(ValidationError):
        BackgroundSpec.model_validate(wrong)
