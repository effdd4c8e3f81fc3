"""Frames found from a whole recording: Gauss-Newton over all rows' shapes and one frame at once.

Shapes are T w with w ~ N(0, 1); each row's w is eliminated (Schur complement), so that what
remains is a small system for the frame.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ccgen.kinematics.rotations import exponential, skew
from ccgen.recordings.frames import Spread
from ccgen.recordings.likelihood import Evidence
from ccgen.recordings.recording import Recording
from ccgen.recordings.sights import CLOSER, FAR, NEAR, Frame, Linear, Sights, linearised

Floats = NDArray[np.float64]

_TURNS = 12
_FAR_TURNS = 5
"""Of them, in which shapes count as hardly known yet."""
_SETTLED = 1e-3
"""Of the standard deviations: changes of a frame below are none."""


def refined(
    sights: Sights,
    frame: Frame,
    spread: Spread,
    transform: Floats,
    share: float,
    known: Evidence | None = None,
    noisy: tuple[bool, bool] = (False, False),
) -> tuple[Sights, Frame]:
    """Find a frame, and the noise of positions where it is not stated.

    Args:
        sights: rows to find it from.
        frame: where to begin.
        spread: how far it may be off.
        transform: T, shape (p, k).
        share: of the rows that count, for those that follow each other tell the same.
        known: what else is known of the rows' states, as from sensors.
        noisy: whether to find the noise of positions too, and of orientations.
    """
    std = _flat(spread)
    free = np.flatnonzero(std > 0)
    states = np.zeros((len(sights), len(transform)))
    moved = np.zeros(len(std))
    least = np.array(sights.least_noise)
    for turn in range(_TURNS):
        nearness = FAR if turn < _FAR_TURNS else CLOSER if turn == _FAR_TURNS else NEAR
        at = linearised(replace(sights, nearness=nearness), frame, states)
        step, states, noise = _step(
            at, sights, frame, states, transform, known, share, std, moved, free
        )
        moved += step
        frame = _changed(frame, step)
        if turn > _FAR_TURNS:
            sights = _with_noise(sights, noisy, np.maximum(noise, least))
            if not any(noisy) and not np.any(np.abs(step[free]) > _SETTLED * std[free]):
                break
    return sights, frame


def unstated(recording: Recording) -> tuple[bool, bool]:
    """Whether the noise of positions, and of orientations, is to be found."""
    return recording.file.position_noise is None, recording.file.orientation_noise is None


def _flat(spread: Spread) -> Floats:
    parts = (spread.rotation, spread.origin, spread.offset, spread.tangent)
    return np.concatenate([np.ravel(part) for part in parts])


def _step(
    at: Linear,
    sights: Sights,
    frame: Frame,
    states: Floats,
    T: Floats,
    known: Evidence | None,
    share: float,
    std: Floats,
    moved: Floats,
    free: NDArray[np.intp],
) -> tuple[Floats, Floats, Floats]:
    """Change of the frame, the states under it, and the noise of positions that is left."""
    N, p = states.shape
    J = at.by_state.reshape(N, -1, p)
    F = _by_frame(at, sights, frame)[:, :, free]
    weight = np.repeat(at.weight, 3, axis=1)
    residual = at.residual.reshape(N, -1)
    target = residual + (J @ states[..., None])[..., 0]
    JT = J @ T
    WJT = JT * weight[..., None]
    A = np.eye(T.shape[1]) + np.swapaxes(WJT, 1, 2) @ JT
    c = (target[:, None, :] @ WJT)[:, 0]
    if known is not None:
        A = A + T.T @ known.information @ T
        c = c + known.potential @ T
    inverse = np.asarray(np.linalg.inv(A), dtype=np.float64)
    cross = np.swapaxes(WJT, 1, 2) @ F
    S = np.einsum("nqf,nq,nqg->fg", F, weight, F, optimize=True) - np.einsum(
        "nkf,nkl,nlg->fg", cross, inverse, cross, optimize=True
    )
    g = np.einsum("nqf,nq,nq->f", F, weight, target, optimize=True) - np.einsum(
        "nkf,nkl,nl->f", cross, inverse, c, optimize=True
    )
    precision = np.diag(1 / np.square(std[free]))
    step = np.zeros(len(std))
    step[free] = np.linalg.solve(share * S + precision, share * g - precision @ moved[free])
    w = (inverse @ (c - (cross @ step[free]))[..., None])[..., 0]
    left: Floats = target - (JT @ w[..., None])[..., 0] - F @ step[free]
    return step, w @ T.T, _noise(at, JT, inverse, left)


def _with_noise(sights: Sights, noisy: tuple[bool, bool], noise: Floats) -> Sights:
    """The same rows with the noise that was found, where it is sought and there is any."""
    before = sights.position_noise, sights.orientation_noise
    position, orientation = (
        float(found) if wanted else old
        for wanted, found, old in zip(noisy, noise, before, strict=True)
    )
    return replace(sights, position_noise=position, orientation_noise=orientation)


def _noise(at: Linear, JT: Floats, inverse: Floats, left: Floats) -> Floats:
    """Standard deviations of positions and orientations, what the shapes leave open included."""
    N, (B, Q) = len(JT), (at.place.shape[1], at.trust.shape[1])
    variance = np.einsum("nqk,nkl,nql->nq", JT, inverse, JT, optimize=True)
    square = (np.square(left) + variance).reshape(N, Q, 3).sum(axis=2)
    square = square / np.repeat([3.0, 2.0], B)[:Q]
    parts = (slice(0, B), slice(B, Q))
    count = [int((at.trust[:, part] > 0).sum()) for part in parts]
    total = [float((at.trust[:, part] * square[:, part]).sum()) for part in parts]
    return np.array([np.sqrt(s / n) if n else 0.0 for s, n in zip(total, count, strict=True)])


def _by_frame(at: Linear, sights: Sights, frame: Frame) -> Floats:
    """Derivative of what is expected by rotation, origin, offsets and tangents of the frame."""
    (N, B), Q = at.place.shape[:2], at.trust.shape[1]
    by = np.zeros((N, Q, 3, 6 + 6 * B))
    expected = at.seen.position + (at.seen.rotation @ frame.offset[..., None])[..., 0]
    by[:, :B, :, :3] = -skew(expected)
    by[:, :B, :, 3:6] = np.eye(3)
    for b in range(B):
        by[:, b, :, 6 + 3 * b : 9 + 3 * b] = at.seen.rotation[:, b]
    if Q > B:
        along = at.seen.rotation[..., 2]
        across = np.eye(3) - along[..., :, None] * along[..., None, :]
        by[:, B:, :, :3] = across
        own = across @ frame.rotation.T @ np.nan_to_num(sights.rotation)
        for b in range(B):
            tilted = 6 + 3 * B + 3 * b
            by[:, B + b, :, tilted : tilted + 3] = -own[:, b]
    return by.reshape(N, 3 * Q, -1)


def _changed(frame: Frame, step: Floats) -> Frame:
    B = len(frame.offset)
    turned, moved = step[:3], step[3:6]
    return Frame(
        frame.rotation @ exponential(turned),
        frame.origin + frame.rotation @ moved,
        frame.offset + step[6 : 6 + 3 * B].reshape(B, 3),
        (exponential(step[6 + 3 * B :].reshape(B, 3)) @ frame.tangent[..., None])[..., 0],
    )
