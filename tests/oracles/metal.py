"""What a rough, brushed or filmed metal reflects, evaluated directly in numpy.

Reflectance: M. Born and E. Wolf, "Principles of Optics", 1.6 (films) and 14.2 (metals). Rough
metals: E. Heitz, "Understanding the masking-shadowing function in microfacet-based BRDFs",
J. Computer Graphics Techniques 3 (2014), GGX with separate masking and shadowing.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

TABLES = Path(__file__).resolve().parents[2] / "simtip" / "spectra" / "tables"


def index(metal: str, wavelength_nm: list[float]) -> np.ndarray:
    """Read n + ik of a data set as it is stored, with straight lines in between."""
    path = TABLES / f"metal_{metal}.csv"
    rows = [
        [float(x) for x in row]
        for row in csv.reader(path.read_text().splitlines())
        if row and row[0][:1].isdigit()
    ]
    um, n, k = np.array(rows).T
    nm = 1000 * um
    return np.interp(wavelength_nm, nm, n) + 1j * np.interp(wavelength_nm, nm, k)


def fresnel(m: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Reflectance for unpolarised light from air."""
    inside = np.sqrt(m**2 - (1 - cosine**2))
    s = (cosine - inside) / (cosine + inside)
    p = (m**2 * cosine - inside) / (m**2 * cosine + inside)
    return (np.abs(s) ** 2 + np.abs(p) ** 2) / 2


def filmed(m: complex, film: float, thickness_nm: float, wavelength_nm: float) -> float:
    """Reflectance at normal incidence of a film on a metal, by its transfer matrix."""
    delta = 2 * np.pi * film * thickness_nm / wavelength_nm
    matrix = np.array(
        [[np.cos(delta), -1j * np.sin(delta) / film], [-1j * film * np.sin(delta), np.cos(delta)]]
    )
    b, c = matrix @ [1, m]
    return float(abs((b - c) / (b + c)) ** 2)


def _lambda(w: np.ndarray, alpha: tuple[float, float]) -> np.ndarray:
    tan2 = ((w[..., 0] * alpha[0]) ** 2 + (w[..., 1] * alpha[1]) ** 2) / w[..., 2] ** 2
    return (np.sqrt(1 + tan2) - 1) / 2


def ggx(wi: np.ndarray, wo: np.ndarray, alpha: tuple[float, float], m: np.ndarray) -> np.ndarray:
    """BRDF times the cosine of wo, (..., channels), in the frame of across, along, normal."""
    h = wi + wo
    h = h / np.linalg.norm(h, axis=-1, keepdims=True)
    ellipse = (h[..., 0] / alpha[0]) ** 2 + (h[..., 1] / alpha[1]) ** 2 + h[..., 2] ** 2
    density = 1 / (np.pi * alpha[0] * alpha[1] * ellipse**2)
    unmasked = 1 / ((1 + _lambda(wi, alpha)) * (1 + _lambda(wo, alpha)))
    shown = (wi[..., 2] > 0) & (wo[..., 2] > 0)
    strength = np.where(shown, density * unmasked / (4 * np.where(shown, wi[..., 2], 1)), 0)
    return strength[..., None] * fresnel(m, (wi * h).sum(axis=-1)[..., None])


def ggx_albedo(cosine: float, alpha: tuple[float, float], steps: int = 400) -> float:
    """Part of the light that a perfect mirror of this roughness throws back at the first bounce.

    By the visible normals, whose density is even in Heitz's squares: a sum over them of the
    shadowing alone (E. Heitz, "Sampling the GGX distribution of visible normals", JCGT 7, 2018).
    """
    u, v = np.meshgrid(*2 * [(np.arange(steps) + 0.5) / steps])
    wi = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
    stretched = np.array([alpha[0] * wi[0], alpha[1] * wi[1], wi[2]])
    stretched /= np.linalg.norm(stretched)
    t1 = np.array([0.0, 1.0, 0.0])
    t2 = np.cross(stretched, t1)
    r, phi = np.sqrt(u), 2 * np.pi * v
    a, b = r * np.cos(phi), r * np.sin(phi)
    s = (1 + stretched[2]) / 2
    b = (1 - s) * np.sqrt(1 - a**2) + s * b
    c = np.sqrt(np.maximum(0, 1 - a**2 - b**2))
    n = a[..., None] * t1 + b[..., None] * t2 + c[..., None] * stretched
    h = np.stack([alpha[0] * n[..., 0], alpha[1] * n[..., 1], np.maximum(n[..., 2], 0)], axis=-1)
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    wo = 2 * (h @ wi)[..., None] * h - wi
    up = wo[..., 2] > 0
    return float(np.where(up, 1 / (1 + _lambda(np.where(up[..., None], wo, wi), alpha)), 0).mean())
