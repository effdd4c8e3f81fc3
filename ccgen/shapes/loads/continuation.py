"""Loads raised from zero: the equilibria that follow from the straight joint, all samples at once.

Each joint takes its own steps along its own branch: a predictor along the tangent, then Newton's
iterations. A step that leaves the basin of the branch, or meets a Hessian that is not positive
definite, is taken again at a quarter. Where only tiny steps are left the branch has lost its
stability: the joint buckles.

Loads that would bend a segment beyond a limit are raised only until it is met.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.shapes.loads import spatial
from ccgen.shapes.loads.equilibrium import Array, DeadLoads, Flags, Index, Newton, Rods, Step

REACHED, LIMITED, OUTSIDE, LOST = range(4)
"""What became of a joint: within the limit under all loads; scaled back to the limit; beyond the
limit under all loads and from the start; buckled."""

STEEPEST = np.pi / 2
"""Angle beyond which no segment of constant curvature is taken for a joint's, radians."""

_ON_THE_WAY = -1

_TURN = 0.5
"""Largest turn of an element's end in a predicted step at first, and in a correction, radians."""
_LONGEST_TURN = 2.0
"""Of a predicted step where corrections have stayed below `_EASY`, radians."""
_EASY = 0.02
_NEAR = 1e-2
_AT_THE_END = 1e-8
"""Corrections that count as converged, radians; the next one would be about their square."""
_CORRECTIONS = 7
_STEERED, _STEERINGS = 4.0, 3
"""Turn, as a share of the correction's, and number of corrections by which the factor of a trial
that aims at the limit follows them."""
_SMALLEST_STEP = 1e-6
"""Share of the loads reached so far; the branch ends where only smaller steps are left."""
_MOST_EVALUATIONS = 600
_MARGIN = 5e-10
"""Half the share of the limit by which a scaled shape may stay within it; it does not pass it."""


@dataclass(frozen=True, eq=False)
class Limit:
    """How far segments may bend.

    Attributes:
        starts: first element of each segment, shape (m,).
        largest: angle of a segment and axis, shape (N,), radians.
    """

    starts: Index
    largest: Array


@dataclass(frozen=True, eq=False)
class Raised:
    """The last equilibrium of each joint on its branch.

    Attributes:
        angles: of the elements, shape (E, axes, N), radians.
        factor: of the raised loads, shape (N,).
        outcome: REACHED, LIMITED, OUTSIDE or LOST, shape (N,).
    """

    angles: Array
    factor: Array
    outcome: NDArray[np.int8]


def raise_loads(
    rods: Rods,
    held: DeadLoads,
    raised: DeadLoads,
    limit: Limit,
    start: Array,
    newton: Newton = spatial.newton,
) -> Raised:
    """Raise loads from none to all of them.

    Args:
        rods: the N joints.
        held: loads that are there from the start.
        raised: loads that are raised.
        limit: of the segments' angles.
        start: equilibrium under the held loads, shape (E, axes, N), radians.
        newton: its step, in space or in a plane.
    """
    walk = _Walk(limit, start)
    walking = np.arange(start.shape[-1])
    for _ in range(_MOST_EVALUATIONS):
        still = walk.outcome[walking] == _ON_THE_WAY
        if not still.all():
            kept, walking = np.flatnonzero(still), walking[still]
            rods, held, raised = rods.of(kept), held.of(kept), raised.of(kept)
        if not walking.size:
            break
        trial, factor = walk.angles[..., walking], walk.factor[walking]
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            walk.judge(walking, newton(trial, rods, held, raised, factor))
    return walk.end()


class _Walk:
    """Where each joint stands on its branch, and what it tries next."""

    def __init__(self, limit: Limit, start: Array) -> None:
        n = start.shape[-1]
        self._limit = limit
        self.outcome = np.full(n, _ON_THE_WAY, dtype=np.int8)
        # What is tried.
        self.angles, self.factor = start.copy(), np.zeros(n)
        self._aimed = np.zeros(n, dtype=bool)
        self._corrections, self._first_correction = np.zeros(n, dtype=np.intp), np.zeros(n)
        # The last equilibrium that is not known to lie beyond a crossing of the limit.
        self._base_angles, self._base_tangent = start.copy(), np.zeros_like(start)
        self._base, self._inside = np.zeros(n), np.zeros(n, dtype=bool)
        # A factor beyond the crossing, and how long a step may be.
        self._beyond = np.full(n, np.inf)
        self._longest_step, self._longest_turn = np.ones(n), np.full(n, _TURN)

    def judge(self, samples: Index, step: Step) -> None:
        """Take Newton's step; where the trial ends with it begin the next."""
        turn = _largest_turn(step.correction)
        first = self._corrections[samples] == 0
        self._first_correction[samples[first]] = turn[first]
        self._corrections[samples] += 1
        failed = ~step.stable | ~(turn < _TURN) | (self._corrections[samples] > _CORRECTIONS)
        exact = self._aimed[samples] | (self.factor[samples] == 1.0)
        done = ~failed & (turn < np.where(exact, _AT_THE_END, _NEAR))
        self.angles[..., samples[~failed]] += step.correction[..., ~failed]
        early = done | (self._corrections[samples] <= _STEERINGS)
        steered = ~failed & self._aimed[samples] & early
        if steered.any():
            self._steer(samples[steered], step.tangent[..., steered], turn[steered])
        if failed.any():
            self._retreat(samples[failed])
        if done.any():
            self._advance(samples[done], step.tangent[..., done])

    def _steer(self, samples: Index, tangent: Array, turn: Array) -> None:
        """Let the factor of trials that aim at the limit follow what a correction changed.

        Not far, and at first only, so that trials come to rest.
        """
        bend, rate = _bend(self.angles[..., samples], tangent, self._limit.starts)
        step = (self._limit.largest[samples] * (1 - _MARGIN) - bend) / rate
        ahead = self.factor[samples] + step
        farthest = np.minimum(self._beyond[samples], 1.0)
        within = (self._base[samples] < ahead) & (ahead < farthest)
        near = np.abs(step) * _largest_turn(tangent) <= np.maximum(_STEERED * turn, _AT_THE_END)
        step = np.where(within & near, step, 0.0)
        self.angles[..., samples] += tangent * step
        self.factor[samples] += step

    def end(self) -> Raised:
        """The last equilibria; who is still on the way is lost."""
        lost = np.isin(self.outcome, (_ON_THE_WAY, LOST))
        return Raised(
            angles=np.where(lost, self._base_angles, self.angles),
            factor=np.where(lost, self._base, self.factor),
            outcome=np.where(lost, LOST, self.outcome).astype(np.int8),
        )

    def _retreat(self, samples: Index) -> None:
        """Try a quarter of the step again, or give up."""
        base = self._base[samples]
        step = (self.factor[samples] - base) / 4
        hopeless = step <= _SMALLEST_STEP * (base + _SMALLEST_STEP)
        self.outcome[samples[hopeless]] = LOST
        self._longest_step[samples], self._longest_turn[samples] = step, _TURN
        angles, tangent = self._base_angles[..., samples], self._base_tangent[..., samples]
        self._try(samples, angles, tangent, base, step)

    def _advance(self, samples: Index, tangent: Array) -> None:
        """Take an equilibrium in, and be done or set out from it."""
        angles, factor = self.angles[..., samples], self.factor[samples]
        largest = self._limit.largest[samples]
        bend, rate = _bend(angles, tangent, self._limit.starts)
        inside = bend <= largest
        leaving = ~inside & self._inside[samples]
        self._beyond[samples[leaving]] = factor[leaving]
        self._keep(
            samples[~leaving], angles[..., ~leaving], tangent[..., ~leaving], inside[~leaving]
        )
        full = (factor == 1.0) & ~leaving
        self.outcome[samples[full]] = np.where(inside[full], REACHED, OUTSIDE)
        met = self._aimed[samples] & inside & (bend >= largest * (1 - 2 * _MARGIN))
        self.outcome[samples[met]] = LIMITED
        target = largest * (1 - _MARGIN)
        ahead = _until(angles, tangent, self._limit.starts, target)
        aim = np.where(inside, ahead, (target - bend) / rate)
        self._set_out(samples, angles, tangent, aim)

    def _keep(self, samples: Index, angles: Array, tangent: Array, inside: Flags) -> None:
        """Fall back to these equilibria from now on, and take longer steps."""
        self._base_angles[..., samples], self._base_tangent[..., samples] = angles, tangent
        self._base[samples], self._inside[samples] = self.factor[samples], inside
        self._longest_step[samples] *= 2
        easy = samples[self._first_correction[samples] < _EASY]
        self._longest_turn[easy] = np.minimum(2 * self._longest_turn[easy], _LONGEST_TURN)

    def _set_out(self, samples: Index, angles: Array, tangent: Array, aim: Array) -> None:
        """Choose the next factor: `aim` ahead, at the limit, or as far as a step may go."""
        factor, base, beyond = self.factor[samples], self._base[samples], self._beyond[samples]
        turn = self._longest_turn[samples] / _largest_turn(tangent)
        step = np.minimum(np.minimum(self._longest_step[samples], turn), 1.0 - factor)
        crossing = np.isfinite(beyond)
        aimed = crossing | (self._inside[samples] & (aim <= step))
        step = np.where(aimed, aim, step)
        astray = crossing & ~((factor + step > base) & (factor + step < beyond))
        step = np.where(astray, (base + beyond) / 2 - factor, step)
        # A jump across the limit: between neighbouring factors the joint snaps.
        snapped = astray & (beyond - base <= _SMALLEST_STEP * _MARGIN * beyond)
        self.outcome[samples[snapped]] = LOST
        self._aimed[samples] = aimed
        self._try(samples, angles, tangent, factor, step)

    def _try(
        self, samples: Index, angles: Array, tangent: Array, factor: Array, step: Array
    ) -> None:
        """Predict the equilibria a step further, of those that are still on the way."""
        going = self.outcome[samples] == _ON_THE_WAY
        samples, step = samples[going], step[going]
        self.angles[..., samples] = angles[..., going] + tangent[..., going] * step
        ahead = factor[going] + step
        self.factor[samples] = np.where(ahead > 1.0 - 1e-12, 1.0, ahead)
        self._corrections[samples] = 0


def _largest_turn(angles: Array) -> Array:
    """How far the elements' ends turn at most, to first order, shape (N,), radians."""
    turns = np.cumsum(angles, axis=0)
    return np.asarray(np.sqrt((turns * turns).sum(axis=1).max(axis=0)))


def _until(angles: Array, tangent: Array, starts: Index, largest: Array) -> Array:
    """How far it is until the first of the segments' angles is as large as may be, shape (N,)."""
    segments = np.add.reduceat(angles, starts, axis=0)
    rates = np.add.reduceat(tangent, starts, axis=0)
    ahead = (largest - np.sign(rates) * segments) / np.abs(rates)
    return np.asarray(ahead.min(axis=(0, 1)))


def _bend(angles: Array, tangent: Array, starts: Index) -> tuple[Array, Array]:
    """The largest angle of a segment and axis, and its rate, shape (N,)."""
    segments = np.add.reduceat(angles, starts, axis=0).reshape(-1, angles.shape[-1])
    rates = np.add.reduceat(tangent, starts, axis=0).reshape(segments.shape)
    which = np.abs(segments).argmax(axis=0)[None]
    bend = np.take_along_axis(segments, which, axis=0)[0]
    rate = np.take_along_axis(rates, which, axis=0)[0]
    return np.abs(bend), np.sign(bend) * rate
