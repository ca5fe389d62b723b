"""Move a needle until both pictures are explained best (Levenberg and Marquardt).

Unknown are the apex (3), the axis (2), the roll (1, unless it changes nothing) and the blur of each
picture. The brightness of each is eliminated (variable projection).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array, Pose
from simtip.refine.place import moved
from simtip.refine.solid import Solid
from simtip.refine.view import Fit, View

POSE = 6
STEPS = np.array([2e-4, 2e-4, 2e-4, 2e-5, 2e-5, 2e-4])
"""Of differences: mm and rad, some 0.002 px. Coverage has a kink where an edge leaves a pixel."""

BLUR_STEP_PX = 0.02
BLUR_SHARE, BLUR_PX = 0.2, 0.1
"""Usual deviation of the blur from what the shaft shows: relative, and px."""

FARTHEST = np.array([1.0, 1.0, 1.0, 0.05, 0.05, 0.5])
"""A step goes no further."""

SETTLED = 0.1
"""The fit ends where a whole step promises to lower the cost, chi square over the misfit, by less:
by a third of a deviation at most."""

VAIN = 5
"""It ends, too, at a step that failed and promised less than so many times that, 0.7 of a
deviation: coverage has kinks, at which a slope promises what is not there."""

MOST_DAMPING = 1e3


@dataclass(frozen=True, eq=False)
class State:
    """A place of the needle, the blur of both pictures, and how well they fit."""

    T_wn: Pose
    blur: Array
    fits: tuple[Fit, Fit]
    cost: float


@dataclass(frozen=True, eq=False)
class Solution:
    """The best state and its covariance.

    Attributes
    ----------
    state
        The best.
    covariance
        (n, n) of the apex (mm), the turns about it (rad) and both blurs (px).
    settled
        It ended because nothing changed any more.
    """

    state: State
    covariance: Array
    settled: bool


@dataclass(frozen=True, eq=False)
class Problem:
    """Both pictures and the needle that is in them."""

    solid: Solid
    views: tuple[View, View]

    def with_noise_left(self, fits: Sequence[Fit]) -> Problem:
        """Give the same with the noise that fits to both pictures leave, see `View`."""
        left, right = (
            view.with_noise_left(fit) for view, fit in zip(self.views, fits, strict=True)
        )
        return replace(self, views=(left, right))

    @property
    def free(self) -> NDArray[np.intp]:
        """Numbers of the free parameters."""
        return np.flatnonzero([k != 5 or not self.solid.revolution for k in range(POSE + 2)])

    def state(self, T_wn: Pose, blur: Array) -> State:
        """Compare the pictures with the needle in a place."""
        left, right = (
            view.fit(self.solid, T_wn, float(b)) for view, b in zip(self.views, blur, strict=True)
        )
        off = self._off(blur)
        return State(T_wn, blur, (left, right), left.cost + right.cost + float(off @ off))

    def start(self, T_wn: Pose) -> State:
        """Compare them with the needle in its first place."""
        return self.state(T_wn, np.array([view.blur_px for view in self.views]))

    def _deviation(self) -> Array:
        return np.array([BLUR_PX + BLUR_SHARE * view.blur_px for view in self.views])

    def _off(self, blur: Array) -> Array:
        usual = np.array([view.blur_px for view in self.views])
        return np.asarray((blur - usual) / self._deviation())

    def equations(self, state: State) -> tuple[Array, Array]:
        """Give normal matrix and right side of the free parameters."""
        H, g = np.zeros((POSE + 2, POSE + 2)), np.zeros(POSE + 2)
        for k, (view, fit) in enumerate(zip(self.views, state.fits, strict=True)):
            blur = float(state.blur[k])
            steps = np.append(STEPS, BLUR_STEP_PX)
            pose = [p for p in range(POSE) if p != 5 or not self.solid.revolution]
            places = [
                (moved(state.T_wn, self.solid.apex, STEPS[p] * np.eye(POSE)[p]), blur) for p in pose
            ]
            places.append((state.T_wn, blur + BLUR_STEP_PX))
            which = np.array([*pose, POSE])
            base = fit.columns @ fit.amplitude
            D = view.change(fit, self.solid, places, steps[which], base)
            weighted = D * fit.weight[:, None]
            cross = fit.columns.T @ weighted
            shed = np.linalg.solve(fit.normal, cross)
            at = np.array([*pose, POSE + k])
            H[np.ix_(at, at)] += D.T @ weighted - cross.T @ shed
            g[at] += weighted.T @ fit.residual
        deviation = self._deviation()
        H[[POSE, POSE + 1], [POSE, POSE + 1]] += 1 / deviation**2
        g[POSE:] -= self._off(state.blur) / deviation
        free = self.free
        return H[np.ix_(free, free)], g[free]

    def stepped(self, state: State, step: Array) -> State:
        """Compare after a step of the free parameters."""
        whole = np.zeros(POSE + 2)
        whole[self.free] = step
        pose = np.clip(whole[:POSE], -FARTHEST, FARTHEST)
        blur = np.maximum(state.blur + whole[POSE:], 0)
        return self.state(moved(state.T_wn, self.solid.apex, pose), blur)

    def settle(self, state: State, most: int = 25) -> Solution:
        """Step until the cost does not fall any more."""
        damping, settled = 1e-3, False
        H, g = self.equations(state)
        for _ in range(most):
            enough = SETTLED * max(1.0, *(fit.misfit for fit in state.fits))
            promised = float(g @ self._step(state, H, g, 0.0))
            settled = promised < enough
            if settled:
                break
            tried = self.stepped(state, self._step(state, H, g, damping))
            gain = state.cost - tried.cost
            if gain > 0:
                state = tried
                damping = max(damping / 10, 1e-7)
                H, g = self.equations(state)
            else:
                damping *= 10
            settled = gain < enough / 10 if gain > 0 else promised < VAIN * enough
            settled = settled or damping > MOST_DAMPING
            if settled:
                break
        covariance = np.zeros((POSE + 2, POSE + 2))
        free = self.free[~self._held(state, g)]
        kept = ~self._held(state, g)
        covariance[np.ix_(free, free)] = np.linalg.inv(H[np.ix_(kept, kept)])
        return Solution(state, covariance, settled)

    def _held(self, state: State, g: Array) -> NDArray[np.bool_]:
        """Tell which free parameters are blurs that would fall below nothing."""
        held = np.zeros(len(g), np.bool_)
        held[-2:] = (state.blur <= 0) & (g[-2:] <= 0)
        return held

    def _step(self, state: State, H: Array, g: Array, damping: float) -> Array:
        kept = ~self._held(state, g)
        step = np.zeros(len(g))
        damped = H + damping * np.diag(np.diag(H))
        step[kept] = np.linalg.solve(damped[np.ix_(kept, kept)], g[kept])
        low = kept.copy()
        low[:-2] = False
        low[-2:] &= state.blur + step[-2:] < 0
        if low.any():  # as far as it goes, and the others as if it were fixed there
            step[low] = -state.blur[low[-2:]]
            kept &= ~low
            right = g[kept] - H[np.ix_(kept, low)] @ step[low]
            step[kept] = np.linalg.solve(damped[np.ix_(kept, kept)], right)
        return step
