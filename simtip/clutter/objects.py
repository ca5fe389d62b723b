"""Solid clutter: cables, rods, dust and what throws shadows from out of view.

Each thing draws from a stream of its own and is placed again, up to `TRIES` times, until it keeps
its distances; if it cannot, it is left out. So one thing never moves another, and a needle that
moves displaces only what is in its way. Things may run through each other.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import scipy

from simtip.clutter.prints import TILE_MM, between, lognormal, tiles
from simtip.clutter.setting import LampPlace, Setting
from simtip.clutter.solids import SIDES, Faces, ellipsoid, tube
from simtip.geometry import Array, unit
from simtip.seeding import stream
from simtip.spec.clutter import ClutterAmounts, ClutterSpec

TRIES = 200
GAP_MM = 0.01
"""Between the board and what lies on it: no two surfaces coincide."""

HANG_MM = 25.0
"""What hangs before the board is at most so far from it."""

SAG_MM = 8.0
"""What hangs rises and falls by at most so much."""

SPACING_MM = 1.5
"""Between points of a spine, about."""

BEND = 4.0
"""Cables bend no tighter than so many of their radii."""

CABLES = (
    (0.03, 0.03, 0.03),
    (0.35, 0.35, 0.36),
    (0.60, 0.58, 0.54),
    (0.45, 0.05, 0.04),
    (0.05, 0.10, 0.40),
)
"""Their colours: black, gray, beige, red, blue."""

GLOSSY_SIDES = 96
"""Of a glossy thing's polygon: its streaks of light would show coarser facets."""

Finish = Literal["matt", "glossy"]
Rng = np.random.Generator


@dataclass(frozen=True, eq=False)
class ClutterObject:
    """One solid thing; world frame, mm.

    Attributes
    ----------
    name
        Its own, e.g. "cable_1".
    kind
        "cable", "rod", "dust", "lint" or "shadow".
    vertices, faces
        (n, 3) and (m, 3), closed, outward.
    albedo
        (3,) diffuse reflectance; of a glossy thing, that of its body for what its coat lets in.
    in_view
        It is to be seen and belongs in the truth mask; a shadow's caster is not.
    finish
        How it reflects: a matt body, "glossy" with a clear coat.
    diameter_mm
        Its thickness; of dust, its shortest axis.
    """

    name: str
    kind: str
    vertices: Array
    faces: Faces
    albedo: Array
    in_view: bool
    finish: Finish
    diameter_mm: float

    def to_dict(self) -> dict[str, Any]:
        """Give what is true of it, for ``truth.json``."""
        return {
            "name": self.name,
            "kind": self.kind,
            "in_view": self.in_view,
            "finish": self.finish,
            "albedo": self.albedo.tolist(),
            "diameter_mm": self.diameter_mm,
            "low_mm": self.vertices.min(axis=0).tolist(),
            "high_mm": self.vertices.max(axis=0).tolist(),
        }


def objects(clutter: ClutterSpec, setting: Setting, seed: int) -> tuple[ClutterObject, ...]:
    """Place a scene's solid clutter.

    All keep `NEEDLE_CLEAR_MM` from the needle, `CAMERA_CLEAR_MM` from the cameras and, in both
    images, `tip_clear_mm` from the tip. Without `occlude` all that is in view lies behind the
    needle: nearer to the board than the needle's nearest point.

    Parameters
    ----------
    clutter
        What is wanted.
    setting
        What is there.
    seed
        The scene's; `clutter.seed` stands above it.

    Returns
    -------
    objects
        Fewer than wanted where there is no room, and no shadows without lamps: `objects_truth`
        says so.

    Raises
    ------
    InputError
        The cameras see more of the board than can be strewn with dust.
    """
    amounts = clutter.amounts()
    seed = seed if clutter.seed is None else clutter.seed
    if setting.box is None:
        return ()
    place = _Placing(amounts, setting, *setting.box, occlude=clutter.occlude)
    found: list[ClutterObject] = []
    for kind, count in (("cable", amounts.cables), ("rod", amounts.rods)):
        for k in range(count):
            rng = stream(seed, "clutter", kind, k)
            make = place.cable if kind == "cable" else place.rod
            found += [thing for thing in [make(rng, f"{kind}_{k + 1}")] if thing]
    for k in range(amounts.shadows if setting.lamps else 0):
        rng = stream(seed, "clutter", "shadow", k)
        found += [thing for thing in [place.shadow(rng, f"shadow_{k + 1}")] if thing]
    return (*found, *place.dust(seed))


def objects_truth(clutter: ClutterSpec, things: Sequence[ClutterObject]) -> dict[str, Any]:
    """Give the list of a scene's solid clutter, and what was wanted, for ``truth.json``."""
    amounts, count = clutter.amounts(), Counter(thing.kind for thing in things)
    wanted = {"cable": amounts.cables, "rod": amounts.rods, "shadow": amounts.shadows}
    return {
        "level": clutter.level,
        "left_out": {k: n - count[k] for k, n in wanted.items() if n > count[k]},
        "objects": [thing.to_dict() for thing in things],
    }


def grouped(things: Sequence[ClutterObject]) -> tuple[ClutterObject, ...]:
    """Join things of one look into one mesh each, so that a renderer has few shapes."""
    groups: dict[tuple[Any, ...], list[ClutterObject]] = defaultdict(list)
    for thing in things:
        groups[thing.in_view, thing.finish, *thing.albedo.tolist()].append(thing)
    return tuple(_joined(group) for group in groups.values())


def _joined(group: list[ClutterObject]) -> ClutterObject:
    first = group[0]
    starts = np.cumsum([0, *(len(thing.vertices) for thing in group)])
    return ClutterObject(
        name=first.name if len(group) == 1 else f"{first.name}_and_{len(group) - 1}",
        kind=first.kind if len({thing.kind for thing in group}) == 1 else "mixed",
        vertices=np.concatenate([thing.vertices for thing in group]),
        faces=np.concatenate([t.faces + n for t, n in zip(group, starts[:-1], strict=True)]),
        albedo=first.albedo,
        in_view=first.in_view,
        finish=first.finish,
        diameter_mm=min(thing.diameter_mm for thing in group),
    )


@dataclass(frozen=True, eq=False)
class _Placing:
    """One scene's rules and the box (low, high) of the board that is seen."""

    amounts: ClutterAmounts
    setting: Setting
    low: Array
    high: Array
    occlude: bool

    def cable(self, rng: Rng, name: str) -> ClutterObject | None:
        """Lay a bent cable across the view, on the board or hanging a little before it."""
        radius = between(rng, self.amounts.cable_diameter_mm) / 2
        colour = np.array(CABLES[rng.integers(len(CABLES))])
        for _ in range(TRIES):
            st = self._across(rng)
            lift = self._height(rng.random(3), radius + GAP_MM, rest=0.5)
            sag = np.sin(np.linspace(0, np.pi, len(st)) + rng.uniform(0, np.pi))
            slack = min((lift - radius - GAP_MM) / 2, SAG_MM)
            spine = self.setting.at(st, lift + slack * sag)
            if _bend_radius(spine) > BEND * radius and self._fits(spine, radius):
                return _solid(name, "cable", spine, np.full(len(spine), radius), colour)
        return None

    def rod(self, rng: Rng, name: str) -> ClutterObject | None:
        """Hang a straight gray rod, about as thick as the needle and roughly parallel to it."""
        setting = self.setting
        radius = setting.needle_radius_mm * rng.uniform(0.7, 1.4)
        gray = np.full(3, rng.uniform(0.25, 0.6))
        finish: Finish = "glossy" if rng.random() < 0.5 else "matt"
        point = radius * rng.uniform(3, 8) if rng.random() < 0.5 else 0.0
        board, size = setting.board, self.high - self.low
        hub = setting.needle_mm[-1] - setting.needle_mm[0]
        upright = np.arctan2(hub @ board.y, hub @ board.x)
        for _ in range(TRIES):
            angle = upright + np.clip(rng.normal(0, 0.5), -1.2, 1.2)
            foremost = self.low + size * rng.uniform(0.2, 0.8, 2)
            length = rng.uniform(0.4, 1.2) * float(size.min())
            back = foremost + length * np.array([np.cos(angle), np.sin(angle)])
            heights = np.array(
                [self._height(rng.random(3), radius + GAP_MM, rest=0.3) for _ in range(2)]
            )
            ends = setting.at(np.stack([foremost, back]), heights)
            steps = np.linalg.norm(ends[1] - ends[0]) / SPACING_MM
            share = np.linspace(0, 1, max(int(steps), 2) + 1)
            spine = ends[0] + share[:, None] * (ends[1] - ends[0])
            along = share * np.linalg.norm(ends[1] - ends[0])
            radii = radius * (np.clip(along / point, 0.02, 1) if point else np.ones(len(spine)))
            if setting.both_see(ends[0]) and self._fits(spine, radius):
                return _solid(name, "rod", spine, radii, gray, finish)
        return None

    def shadow(self, rng: Rng, name: str) -> ClutterObject | None:
        """Put a bar out of view between a lamp and a place on the board that is in view."""
        setting, size = self.setting, self.high - self.low
        radius = rng.uniform(3, 12)
        for _ in range(TRIES):
            lamp = setting.lamps[int(rng.integers(len(setting.lamps)))]
            target = self.low + size * rng.uniform(0.2, 0.8, 2)
            foot = setting.at(target, np.array(0.0))
            if not setting.both_see(foot):
                continue
            direction = _along_lamp(lamp, foot, rng)
            length, share = rng.uniform(0.3, 1.0) * float(size.max()), rng.uniform(0.0, 0.15)
            steps = np.linspace(-0.5, 0.5, max(int(length / SPACING_MM), 2) + 1)
            bar = steps[:, None] * length * direction
            for nearer in np.linspace(0.02, 0.6, 59) + share:
                spine = foot + nearer * (lamp.centre_mm - foot) + bar
                if self._shades(spine, radius):
                    radii = np.full(len(spine), radius)
                    return _solid(name, "shadow", spine, radii, np.full(3, 0.2), in_view=False)
        return None

    def dust(self, seed: int) -> Iterator[ClutterObject]:
        """Strew grains on the board and lint before it, by tiles of the board."""
        amounts, number = self.amounts, 0
        if amounts.dust_per_100cm2 == 0:
            return
        for j, i in tiles(self.low, self.high):
            rng = stream(seed, "clutter", "dust", j, i)
            count = int(rng.poisson(amounts.dust_per_100cm2))
            centres = (np.array([i, j]) + rng.random((count, 2))) * TILE_MM
            diameters = lognormal(rng, amounts.dust_mm, amounts.dust_sigma, count)
            shapes = rng.random((count, 8))
            for st, diameter, shape in zip(centres, diameters, shapes, strict=True):
                if not ((st >= self.low) & (st <= self.high)).all():
                    continue
                thing = self._grain(st, diameter, shape, number + 1)
                if thing:
                    number += 1
                    yield thing

    def _grain(self, st: Array, diameter: float, u: Array, number: int) -> ClutterObject | None:
        """Make a flat grain that lies, or lint that hangs, from eight uniform numbers."""
        board, hangs = self.setting.board, u[0] < 0.25
        turn = 2 * np.pi * u[1]
        ahead = np.cos(turn) * board.x + np.sin(turn) * board.y
        aside = np.cross(board.normal, ahead)
        up = board.normal
        half = diameter / 2
        if hangs:  # tilted out of the board's plane
            tilt = (u[2] - 0.5) * 2
            c, s = np.cos(tilt), np.sin(tilt)
            ahead, up = c * ahead + s * up, c * up - s * ahead
            semi = half * np.array([4 + 10 * u[3], 0.5, 0.5])
            height = self._height(np.array([1.0, u[4], u[6]]), semi[0] + GAP_MM, rest=0.0)
        else:
            semi = half * np.array([1 + u[2], 1.0, 0.4 + 0.5 * u[3]])
            height = semi[2] + GAP_MM
        centre = self.setting.at(st, np.array(height))
        if not self._fits(centre[None], float(semi.max())):
            return None
        vertices, faces = ellipsoid(centre, np.stack([ahead, aside, up]) * semi[:, None])
        gray = (0.05, 0.2, 0.4, 0.6)[int(u[5] * 4)]  # four grays: few materials
        kind = "lint" if hangs else "dust"
        look = np.full(3, gray)
        thin = 2 * float(semi.min())
        return ClutterObject(f"{kind}_{number}", kind, vertices, faces, look, True, "matt", thin)

    def _fits(self, spine: Array, radius: float) -> bool:
        """Say whether something in view keeps all its distances."""
        setting = self.setting
        top = float(setting.heights(spine).max()) + radius
        if not self.occlude and top > setting.below_needle_mm():
            return False
        return setting.is_free(spine, radius) and setting.leaves_tip_free(
            spine, radius + SPACING_MM / 2 if len(spine) > 1 else radius, self.amounts.tip_clear_mm
        )

    def _shades(self, spine: Array, radius: float) -> bool:
        """Say whether a shadow's caster may be here."""
        setting = self.setting
        off_board = setting.heights(spine).min() > radius + GAP_MM
        return bool(
            off_board and setting.is_out_of_view(spine, radius) and setting.is_free(spine, radius)
        )

    def _height(self, u: Array, lowest: float, rest: float) -> float:
        """Give a height from three uniform numbers: the lowest with a chance, else above."""
        if self.occlude and u[2] < 0.5:
            needle = float(self.setting.heights(self.setting.needle_mm).max())
            eyes = float(self.setting.heights(self.setting.eyes).min())
            return max(lowest, needle + float(u[1]) * 0.6 * (eyes - needle))
        return lowest if u[0] < rest else lowest + float(u[1]) * HANG_MM

    def _across(self, rng: Rng) -> Array:
        """Draw a smooth curve (n, 2) over the box, from beyond one side to beyond another."""
        size = self.high - self.low
        middle = (self.low + self.high) / 2
        angle = rng.uniform(0, 2 * np.pi)
        turn = angle + np.pi + rng.normal(0, 0.6)
        ends = np.array([[np.cos(a), np.sin(a)] for a in (angle, turn)])
        ends *= 0.62 / np.abs(ends).max(axis=1, keepdims=True)  # on a square about the box
        start, end = middle + ends * size
        across = np.array([-(end - start)[1], (end - start)[0]])
        knots = np.linspace(0, 1, 6)
        wander = np.concatenate([[0], rng.normal(0, 0.09, 4), [0]])
        path = start + knots[:, None] * (end - start) + wander[:, None] * across
        length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        fine = np.linspace(0, 1, max(int(1.2 * length / SPACING_MM), 8))
        return np.asarray(scipy.interpolate.CubicSpline(knots, path)(fine))


def _bend_radius(spine: Array) -> float:
    """Give the tightest radius, mm, with which a curve (n, 3) bends."""
    step = np.diff(spine, axis=0)
    length = np.linalg.norm(step, axis=1)
    cosine = (unit(step[1:]) * unit(step[:-1])).sum(axis=1)
    turn = np.arccos(np.clip(cosine, -1, 1))
    return float(1 / np.maximum(turn / ((length[1:] + length[:-1]) / 2), 1e-9).max())


def _along_lamp(lamp: LampPlace, foot: Array, rng: Rng) -> Array:
    """Give a bar's direction: about along a long lamp, where its shadow is sharpest."""
    towards = unit(lamp.centre_mm - foot)
    around = rng.normal(0, 1, 3)
    if np.linalg.norm(lamp.half_mm) > 0:
        around = unit(lamp.half_mm) + 0.15 * around
    return unit(around - (around @ towards) * towards)


def _solid(
    name: str,
    kind: str,
    spine: Array,
    radii: Array,
    albedo: Array,
    finish: Finish = "matt",
    *,
    in_view: bool = True,
) -> ClutterObject:
    vertices, faces = tube(spine, radii, GLOSSY_SIDES if finish == "glossy" else SIDES)
    thick = 2 * float(radii.max())
    return ClutterObject(name, kind, vertices, faces, albedo, in_view, finish, thick)
