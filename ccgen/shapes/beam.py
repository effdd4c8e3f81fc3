"""A joint under a load that is raised from zero.

Shooting from the base finds other equilibria too, and several shapes share one base curvature.
Pseudo-arc-length continuation from the unbent joint stays on the one branch that a rising load
follows, through its folds. A branch depends on the load case alone: it is followed once, and every
joint picks its states from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.digits import rounded_down
from ccgen.errors import ReachError
from ccgen.shapes.elastica import (
    NODES,
    QUADRATURE,
    SIZE,
    Equilibria,
    FloatArray,
    LoadCase,
    angle_rows,
    base_curvature_row,
    load_row,
    solve,
)

END_FORCE = LoadCase("end-force", force=1.0)
UNIFORM = LoadCase("uniform", uniform=1.0)
S_SHAPE = LoadCase("s-shape", force=1.0, moment=None, limit=100.0)
LOAD_CASES = {case.name: case for case in (END_FORCE, UNIFORM, S_SHAPE)}
"""The cases that bend by a load. An end force of 1000 bends the first of 12 segments by 83 degrees
and of 64 by 33. At 100 the s-shape has long curled back past its base; the first of 12 segments
bends by 34 degrees, of 64 by 9."""

STEP = 0.1
"""Distance of two states of a branch: about the RMS change of the angle in radians."""

_MAX_STATES = 2000
"""A branch that has not passed its limit after so many states is cut off there."""

_PEAK_ITERATIONS = 8

_FLAT = 1e-5
"""Share of the largest angle above which it hardly tells one load from another: no load is asked
for by an angle there."""


@dataclass(frozen=True, eq=False)
class Branch(Equilibria):
    """Neighbouring states in the order in which a load raised from zero passes them.

    `tangents`, shape (n_states, SIZE), points ahead.
    """

    tangents: FloatArray


def bend(case: LoadCase, segments: int, first_segment: ArrayLike) -> Equilibria:
    """Raise the load until the first segment bends by each of the angles.

    Args:
        case: load case.
        segments: how many equal segments the joint has; the first ends at s = 1/segments.
        first_segment: shape (n,), radians, not negative.

    Returns:
        The first state on the branch with each angle, states of shape (n, SIZE).

    Raises:
        ReachError: an angle that no state up to the case's limit reaches.
    """
    targets = np.asarray(first_segment, dtype=np.float64)
    most = float(targets.max(initial=0.0))
    branch, row = _branch_by_first_segment(case, segments, most)
    reach = (1 - _FLAT) * float(np.max(branch.states @ row))
    if most > reach:
        reached = rounded_down(float(np.degrees(reach)), 6)
        which = "the only one" if segments == 1 else f"the first of {segments} segments"
        raise ReachError(
            f"load case {case.name}: a first segment at {np.degrees(most):.6g} degrees is"
            f" out of reach; {which} reaches {reached:.6g} degrees"
            f" (dimensionless loads up to {case.limit:g})"
        )
    return first_crossings(branch, row, targets)


@lru_cache(maxsize=32)
def fold(case: LoadCase) -> Equilibria | None:
    """Locate the first maximum of the base curvature along a branch; None if it only grows."""
    branch, peaks = _with_peaks(follow(case), base_curvature_row())
    return Equilibria(case, branch.states[peaks[0]]) if peaks.size else None


def follow(case: LoadCase) -> Branch:
    """Follow the branch of a load case from the unbent joint until its load passes the limit."""
    return _trail(case).branch()


@dataclass(eq=False)
class _Trail:
    """States and tangents of a branch as far as it has been followed."""

    case: LoadCase
    states: list[FloatArray]
    tangents: list[FloatArray]

    def branch(self, row: FloatArray | None = None, enough: float = 0.0) -> Branch:
        """The branch to its end, or until row . state has passed what is enough."""
        count = 1
        while row is None or float(self.states[count - 1] @ row) <= enough:
            if count == len(self.states) and not self._go_on():
                break
            count += 1
        return Branch(self.case, np.array(self.states[:count]), np.array(self.tangents[:count]))

    def _go_on(self) -> bool:
        state, tangent = self.states[-1], self.tangents[-1]
        if state[NODES] >= self.case.limit or len(self.states) >= _MAX_STATES:
            return False
        state, tangent = _advance(self.case, state, tangent, STEP)
        self.states.append(state)
        self.tangents.append(tangent)
        return True


@lru_cache(maxsize=32)
def _trail(case: LoadCase) -> _Trail:
    state, tangent = solve(case, np.zeros(SIZE), load_row(), 0.0)
    return _Trail(case, [state], [tangent])


def _advance(
    case: LoadCase, state: FloatArray, tangent: FloatArray, distance: float
) -> tuple[FloatArray, FloatArray]:
    """The equilibrium at a distance ahead on the branch, and the tangent there."""
    metric, unit = _arc(state, tangent)
    guess = state + distance * unit
    return solve(case, guess, metric * unit, float(metric @ (unit * guess)))


def _arc(state: FloatArray, tangent: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Diagonal metric of steps from a state, and the tangent at unit length.

    A step counts by the RMS change of the angle and by the change of the loads against their size.
    """
    metric = np.concatenate([QUADRATURE, (10 + np.abs(state[NODES:])) ** -2])
    return metric, tangent / np.sqrt(metric @ tangent**2)


def _branch_by_first_segment(
    case: LoadCase, segments: int, enough: float
) -> tuple[Branch, FloatArray]:
    """The branch with the peaks of the first segment's angle, and the row that picks this angle.

    As far as this angle has passed what is enough, or to its end. Mirrored where need be, so that
    the angle rises from zero: it falls where one segment is the whole joint and bends into an
    s-shape.
    """
    row, trail = angle_rows(np.array([1 / segments]))[0], _trail(case)
    sign = -1.0 if trail.tangents[0] @ row < 0 else 1.0
    branch = trail.branch(sign * row, (1 + 2 * _FLAT) * enough)
    if sign < 0:
        branch = Branch(case, -branch.states, -branch.tangents)
    return _with_peaks(branch, row)[0], row


def first_crossings(branch: Branch, row: FloatArray, targets: FloatArray) -> Equilibria:
    """The first states with row . state = target; targets are within what is reached."""
    values = branch.states @ row
    after = np.maximum(np.searchsorted(np.maximum.accumulate(values), targets), 1)
    before = after - 1
    share = ((targets - values[before]) / (values[after] - values[before]))[:, None]
    guesses = (1 - share) * branch.states[before] + share * branch.states[after]
    return Equilibria(branch.case, solve(branch.case, guesses, row, targets)[0])


def _with_peaks(branch: Branch, row: FloatArray) -> tuple[Branch, NDArray[np.intp]]:
    """The branch with every local maximum of row . state as one more state, and their indices."""
    rates = branch.tangents @ row
    before = np.flatnonzero((rates[:-1] > 0) & (rates[1:] <= 0))
    if before.size == 0:
        return branch, before
    peaks = [_peak(branch, int(index), row) for index in before]
    states = np.insert(branch.states, before + 1, [state for state, _ in peaks], axis=0)
    tangents = np.insert(branch.tangents, before + 1, [tangent for _, tangent in peaks], axis=0)
    return Branch(branch.case, states, tangents), before + 1 + np.arange(before.size)


def _peak(branch: Branch, index: int, row: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Maximum of row . state between a state and the next, by false position on its rate."""
    start, ahead = branch.states[index], branch.tangents[index]
    metric, unit = _arc(start, ahead)
    near, far = 0.0, float(metric @ (unit * (branch.states[index + 1] - start)))
    rate_near, rate_far = float(unit @ row), float(branch.tangents[index + 1] @ row)
    for _ in range(_PEAK_ITERATIONS):
        middle = near + (far - near) * rate_near / (rate_near - rate_far)
        state, tangent = _advance(branch.case, start, ahead, middle)
        rate = float(tangent @ row)
        if rate > 0:
            near, rate_near = middle, rate
        else:
            far, rate_far = middle, rate
    return state, tangent
