"""Where in an image the information about the tip sits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.bound.formation import Picture
from simtip.bound.pose import ViewMoves
from simtip.exposure import GRAY
from simtip.geometry import Array


@dataclass(frozen=True, eq=False)
class InformationMap:
    """Where in one image the information about the apex's place sits.

    Attributes
    ----------
    along, across
        (h, w) information of a pixel about the apex's image position along and across the axis,
        all else known, px^-2; noise may make it negative where there is hardly any.
    image
        (h, w) gray irradiance, W m^-2.
    corner_px
        (u, v) of the first pixel.
    size_px
        Width and height of the whole image.
    moves
        Where the apex is in it.
    """

    along: Array
    across: Array
    image: Array
    corner_px: tuple[int, int]
    size_px: tuple[int, int]
    moves: ViewMoves


def information_map(
    by_pose: Array, told_by: Array, moves: ViewMoves, picture: Picture, irradiance: Array
) -> InformationMap:
    """Spread the information over the pixels.

    Parameters
    ----------
    by_pose
        (R, 6, m, 3) derivatives by `VIEW_POSE` in independent replicas, at the pixels that count.
    told_by
        (m, 3) information of each reading about its mean.
    moves
        How the apex moves in the image.
    picture
        Which pixels these are.
    irradiance
        (h, w, 3) of the window.
    """
    replicas = len(by_pose)
    layers: list[Array] = []
    for move in moves.parallel.T:
        each = np.einsum("k,rkmc->rmc", move, by_pose[:, :3].astype(np.float64))
        products = each.sum(axis=0) ** 2 - (each**2).sum(axis=0)
        layer = np.zeros(picture.touched.shape)
        layer[picture.touched] = (products * told_by).sum(axis=1) / (replicas * (replicas - 1))
        layers.append(layer)
    rows, columns = picture.window
    corner = int(columns.start), int(rows.start)
    image = np.asarray(irradiance @ GRAY, np.float64)
    along, across = layers
    return InformationMap(along, across, image, corner, moves.size_px, moves)
