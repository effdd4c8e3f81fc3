"""Sensors that do not read what the joint file says: swapped, reversed, stuck and slipping ones.

Each is held against what the reference shapes let every sensor expect, with a gain and a zero of
its own, so that no calibration hides it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ccgen.calibration.seen import Seen, correlation, gain_of, pooled

Floats = NDArray[np.float64]

KINDS = ("swapped", "reversed", "stuck", "slipping")

_BETTER = 0.5
"""Share of a sensor's own misfit below which another's place fits it much better."""
_FREE = 1.4
"""Factor by which gains of a joint may differ."""
_FEWEST = 3
"""Readings without which nothing is told of a sensor's place."""
_STILL = 0.05
"""Share of its expected motion below which a sensor stands still."""
_LEAST_MOTION = 10.0
"""Counts that a sensor is expected to move by for anything to be said of it."""
_STUCK_SHARE = 0.05
_PARTS = 60
"""Stretches of time, of which the medians show a step of a zero."""
_FEWEST_PARTS = 8
_STEP = 3.0
"""Deviations of those medians that a step must exceed."""
_STEP_OF_NOISE = 2.5
"""Deviations of a reading that it must exceed besides."""
_APART = 6.0
"""Deviations by which zeros of recordings differ where a sensor slipped between them."""
_ROBUST = 1.4826


@dataclass(frozen=True)
class Suspicion:
    """A sensor that does not read what the joint file says."""

    name: str
    kind: str
    """"swapped", "reversed", "stuck" or "slipping"."""
    text: str


def suspicious(names: Sequence[str], seen: Sequence[Seen]) -> tuple[Suspicion, ...]:
    """Name the sensors that do not read what the joint file says.

    Args:
        names: of the n sensors.
        seen: recordings with reference shapes.
    """
    if not seen:
        return ()
    stuck = dict(_stuck(names, seen))
    rest = [j for j in range(len(names)) if j not in stuck]
    swapped = dict(_swapped(names, seen, rest))
    rest = [j for j in rest if j not in swapped]
    turned = dict(_reversed(names, seen, rest))
    slipping = dict(_slipping(names, seen, rest))
    kinds = zip(KINDS, (swapped, turned, stuck, slipping), strict=True)
    return tuple(
        Suspicion(names[j], kind, found[j]) for kind, found in kinds for j in sorted(found)
    )


@dataclass(frozen=True, eq=False)
class Zeros:
    """Readings of the straight joint in one recording, shape (n,), metres."""

    source: str
    zero: Floats
    std: Floats


def shifted(names: Sequence[str], zeros: Sequence[Zeros], noise: Floats) -> tuple[Suspicion, ...]:
    """Name the sensors whose zero differs between recordings.

    Args:
        names: of the n sensors.
        zeros: of recordings.
        noise: of a reading, shape (n,), metres.
    """
    if len(zeros) < 2:
        return ()
    value, std = np.stack([one.zero for one in zeros]), np.stack([one.std for one in zeros])
    found = []
    for j, name in enumerate(names):
        low, high = int(np.argmin(value[:, j])), int(np.argmax(value[:, j]))
        apart = float(value[high, j] - value[low, j])
        sure = _APART * float(np.hypot(std[low, j], std[high, j]))
        if apart > max(sure, _STEP_OF_NOISE * float(noise[j])):
            text = (
                f"the zero of {name} differs by {1e3 * apart:.2g} mm between {zeros[low].source} "
                f"and {zeros[high].source}: its string or its clamp slips"
            )
            found.append(Suspicion(name, "slipping", text))
    return tuple(found)


def _stuck(names: Sequence[str], seen: Sequence[Seen]) -> Iterator[tuple[int, str]]:
    for j, name in enumerate(names):
        step = abs(seen[0].step[j])
        moves = [_range(one.expected[:, j]) for one in seen]
        reads = [_range(one.raw[:, j]) for one in seen]
        most = int(np.argmax(moves))
        if moves[most] < _LEAST_MOTION * step:
            continue
        if max(reads) <= max(step, _STILL * moves[most]) and _has_readings(seen, j):
            yield (
                j,
                f"{name} stays within {max(reads) / step:.0f} counts while the joint changes its "
                f"length by {1e3 * moves[most]:.2g} mm",
            )
            continue
        share = _stuck_share(seen, j)
        if share > _STUCK_SHARE:
            yield (
                j,
                f"{name} holds one count for {100 * share:.0f} % of its readings while the joint "
                "changes its length",
            )


def _stuck_share(seen: Sequence[Seen], j: int) -> float:
    there = sum(int((~np.isnan(one.raw[:, j])).sum()) for one in seen)
    left = sum(int((~np.isnan(one.raw[:, j]) & np.isnan(one.lengths[:, j])).sum()) for one in seen)
    return left / max(there, 1)


def _has_readings(seen: Sequence[Seen], j: int) -> bool:
    return any(bool((~np.isnan(one.raw[:, j])).any()) for one in seen)


def _range(values: Floats) -> float:
    known = values[~np.isnan(values)]
    return float(np.subtract(*np.percentile(known, (98, 2)))) if len(known) else 0.0


def _swapped(
    names: Sequence[str], seen: Sequence[Seen], rest: Sequence[int]
) -> Iterator[tuple[int, str]]:
    """Sensors that each read what another one should, by the assignment that fits best."""
    from scipy.optimize import linear_sum_assignment

    if len(rest) < 2:
        return
    misfit = _misfits(seen, rest)
    known = np.isfinite(misfit).all(axis=1)
    rest, misfit = list(np.array(rest)[known]), misfit[np.ix_(known, known)]
    if len(rest) < 2:
        return
    _, place = linear_sum_assignment(np.log(np.maximum(misfit, 1e-12)))
    better = misfit[np.arange(len(rest)), place] / np.maximum(np.diag(misfit), 1e-12)
    for i, j in enumerate(place):
        if i == j or np.sqrt(better[i] * better[j]) > _BETTER:
            continue
        own, other = names[rest[i]], names[rest[j]]
        how = f"; {own} and {other} are swapped" if place[j] == i else ""
        yield rest[i], f"{own} reads what {other} should{how}"


def _misfits(seen: Sequence[Seen], rest: Sequence[int]) -> Floats:
    """Root mean square of what the expected changes of one sensor leave of another's readings.

    Gains are free about what is usual for the joint, so that a span twice as long does not fit.

    Returns:
        Shape (k, k): readings of sensor i, places of sensor j; NaN without readings.
    """
    own = [gain_of(*pooled(seen, i, i)) for i in rest]
    usual = float(np.nanmedian(np.abs(own))) if np.isfinite(own).any() else 1.0
    found = np.full((len(rest), len(rest)), np.nan)
    for a, i in enumerate(rest):
        for b, j in enumerate(rest):
            x, y = pooled(seen, i, j)
            if len(y) >= _FEWEST:
                gain = np.clip(np.nan_to_num(gain_of(x, y)), usual / _FREE, usual * _FREE)
                found[a, b] = np.sqrt(np.mean(np.square(y - gain * x)))
    return found


def _reversed(
    names: Sequence[str], seen: Sequence[Seen], rest: Sequence[int]
) -> Iterator[tuple[int, str]]:
    for j in rest:
        x, y = pooled(seen, j, j)
        if correlation(x, y) < -_BETTER:
            yield (
                j,
                f"{names[j]} reads the other way round: the sign of its metres_per_count is wrong, "
                "or the sensor sits on the other side of the joint",
            )


def _slipping(
    names: Sequence[str], seen: Sequence[Seen], rest: Sequence[int]
) -> Iterator[tuple[int, str]]:
    for j in rest:
        for one in seen:
            found = _step_of_zero(one.expected[:, j], one.lengths[:, j], one.noise)
            if found is None:
                continue
            row, step = found
            when = f"{one.t[row]:.3g} s" if one.timed else f"row {row}"
            yield (
                j,
                f"the zero of {names[j]} steps by {1e3 * step:.2g} mm at {when} of {one.source}: "
                "its string or its clamp slips",
            )
            break


def _step_of_zero(expected: Floats, lengths: Floats, usual: float) -> tuple[int, float] | None:
    """Row and size of the step that a zero takes, where it does.

    Args:
        expected: changes of length, shape (N,), metres.
        lengths: readings, shape (N,), metres.
        usual: noise of the joint's readings; shapes that rest on readings hide what is theirs.
    """
    there = np.flatnonzero(~np.isnan(expected) & ~np.isnan(lengths))
    parts = min(_PARTS, len(there) // 4)
    if parts < _FEWEST_PARTS:
        return None
    x, y = expected[there], lengths[there]
    borders = np.linspace(0, len(there), parts + 1).astype(int)
    best = min(range(2, parts - 1), key=lambda k: _split(x, y, int(borders[k]))[1])
    after = int(borders[best])
    (gain, _, step), _ = _split(x, y, after)
    after = _refined(y - gain * x, after, int(borders[best - 1]), int(borders[best + 1]))
    (gain, zero, step), _ = _split(x, y, after)
    residual = y - gain * x - zero - step * (np.arange(len(x)) >= after)
    medians = np.array([np.median(residual[a:b]) for a, b in pairwise(borders)])
    drift = _ROBUST * float(np.median(np.abs(medians - np.median(medians))))
    noise = _ROBUST * float(np.median(np.abs(residual - np.median(residual))))
    if abs(step) <= max(_STEP * drift, _STEP_OF_NOISE * max(noise, usual)):
        return None
    return int(there[after]), float(step)


def _split(x: Floats, y: Floats, after: int) -> tuple[Floats, float]:
    """Gain, zero and step of a zero that steps at a row, and what they leave, in squares."""
    later = (np.arange(len(x)) >= after).astype(np.float64)
    design = np.stack([x, np.ones_like(x), later], axis=1)
    fitted = np.asarray(np.linalg.lstsq(design, y, rcond=None)[0], dtype=np.float64)
    return fitted, float(np.square(y - design @ fitted).sum())


def _refined(off: Floats, after: int, first: int, last: int) -> int:
    """Row within a stretch at which readings change from one level to the other."""
    before, later = float(np.median(off[:after])), float(np.median(off[after:]))
    cost = np.square(off[first:last] - before) - np.square(off[first:last] - later)
    return first + int(np.argmin(np.concatenate([[0.0], np.cumsum(cost)])))
