"""Section 3.2 of Lin et al. (2020), each step on the whole image, one after the other.

What the detector in simtip has to give, bit by bit, however it saves time. Nothing of its code is
used here, only the classes of its parameters and of its answer.
"""

from __future__ import annotations

import cv2
import numpy as np

from simtip.detect.lin2020_parameters import Lin2020Parameters
from simtip.detect.observation import TipObservation, TipStatus

MIN_ELONGATION = 2.0


def detect(image, p: Lin2020Parameters | None = None, *, layers: bool = False) -> TipObservation:
    """Extract the tip; with `layers`, keep the five images of Fig. 7b to 7f."""
    p = p or Lin2020Parameters()
    gray = to_gray(image, p.weights, p.full_scale)
    filtered = cv2.medianBlur(gray, p.median_window)
    binary = np.where(filtered >= p.threshold, np.uint8(255), np.uint8(0))
    cleaned = clean(binary, p)
    edge = cv2.Canny(
        cleaned, p.canny_low, p.canny_high, apertureSize=p.canny_aperture, L2gradient=p.canny_l2
    )
    steps = {
        "gray": gray,
        "filtered": filtered,
        "binary": binary,
        "cleaned": cleaned,
        "edges": edge,
    }
    kept = steps if layers else {}
    if failure := no_needle(filtered, binary, cleaned, p) or no_tip(edge, p):
        return TipObservation.failed(*failure, layers=kept)
    tip = lowest(edge, p.ties)
    return TipObservation.found(tip, axis_px=axis(cleaned, tip, p.connectivity), layers=kept)


def to_gray(image, weights, full_scale):
    white = 255 if image.dtype == np.uint8 else full_scale or 65535
    value = image.astype(np.float64)
    if image.ndim == 3:
        value = value[..., 0] * weights[0] + value[..., 1] * weights[1] + value[..., 2] * weights[2]
    # 1e-9: exact halves, which the weights cannot represent, go up
    return np.ascontiguousarray(np.floor(value * (255 / white) + (0.5 + 1e-9)).astype(np.uint8))


def labelled(mask, connectivity):
    """Labels (H, W), 0 elsewhere, and the area of each."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        mask.astype(np.uint8), connectivity=connectivity
    )
    return labels, stats[:count, cv2.CC_STAT_AREA]


def clean(binary, p):
    cleaned = binary
    for value in {"dark": (0,), "bright": (255,), "both": (0, 255)}[p.polarity]:
        labels, areas = labelled(cleaned == value, p.connectivity)
        small = (areas < p.min_area_px)[labels]
        cleaned = np.where(small, np.uint8(255 - value), cleaned)
    if p.keep == "largest":
        labels, areas = labelled(cleaned == 0, p.connectivity)
        if len(areas) > 1:
            cleaned = np.where(labels == 1 + np.argmax(areas[1:]), np.uint8(0), np.uint8(255))
    return cleaned


def no_needle(filtered, binary, cleaned, p):
    if binary.all():
        reason = f"no pixel is darker than T = {p.threshold} (darkest is {filtered.min()})"
        return TipStatus.NOTHING_DARKER_THAN_THRESHOLD, reason
    if not binary.any():
        reason = f"every pixel is darker than T = {p.threshold} (brightest is {filtered.max()})"
        return TipStatus.EVERYTHING_DARKER_THAN_THRESHOLD, reason
    if cleaned.all():
        areas = labelled(binary == 0, p.connectivity)[1][1:]
        of_how_many = f"the largest of {len(areas)} has {areas.max()} px"
        reason = f"no dark component has {p.min_area_px} px or more ({of_how_many})"
        return TipStatus.NO_COMPONENT_LARGE_ENOUGH, reason
    return None


def no_tip(edge, p):
    rows, columns = np.nonzero(edge)
    if rows.size == 0:
        reason = f"Canny with {p.canny_low:g} / {p.canny_high:g} finds no edge"
        return TipStatus.NO_EDGE, reason
    v = rows.max()
    us = columns[rows == v]
    height, width = edge.shape
    room = min(v, height - 1 - v, us.min(), width - 1 - us.max())
    if room >= p.border_margin_px:
        return None
    reason = (
        f"the lowest edge, at v = {v}, u = {us.min()} to {us.max()}, is {room} px from the border "
        f"of the {width} x {height} image; a tip needs {p.border_margin_px} px"
    )
    return TipStatus.TOUCHES_BORDER, reason


def lowest(edge, ties):
    rows, columns = np.nonzero(edge)
    v = rows.max()
    us = np.sort(columns[rows == v])
    runs = np.split(us, np.flatnonzero(np.diff(us) > 1) + 1)
    u = {"mean": max(runs, key=len).mean(), "left": us[0], "right": us[-1]}[ties]
    return np.array([u, v], dtype=np.float64)


def axis(cleaned, tip, connectivity):
    """Principal axis of the component at the tip, from its moments in whole numbers."""
    labels, _ = labelled(cleaned == 0, connectivity)
    u, v = (int(c) for c in np.floor(tip + 0.5))
    near = labels[max(v - 1, 0) : v + 2, max(u - 1, 0) : u + 2]
    if not near.any():
        return None
    vs, us = np.nonzero(labels == np.bincount(near[near > 0]).argmax())
    n, s_u, s_v = len(us), int(us.sum()), int(vs.sum())
    s_uu, s_uv, s_vv = int((us * us).sum()), int((us * vs).sum()), int((vs * vs).sum())
    uu, uv, vv = n * s_uu - s_u * s_u, n * s_uv - s_u * s_v, n * s_vv - s_v * s_v
    covariance = np.array([[uu / n**2, uv / n**2], [uv / n**2, vv / n**2]])
    variances, directions = np.linalg.eigh(covariance)
    if variances[1] + 1 / 12 < MIN_ELONGATION**2 * (variances[0] + 1 / 12):
        return None
    along = directions[:, 1]
    towards = np.array([s_u - n * tip[0], s_v - n * tip[1]])  # n times as far as the centroid
    return along if along @ towards >= 0 else -along
