"""A joint's poses with 60 digits."""

from decimal import Context, Decimal, localcontext

import numpy as np

from ccgen.fixedpoint.pose import PoseTask

DIGITS = 60


def exact_pose(task: PoseTask, u, v, h=None) -> tuple[np.ndarray, np.ndarray]:
    """Rotation (3, 3) and position (3,), metres, of the tip as decimals; arguments are integers."""
    with localcontext(Context(prec=DIGITS)):
        length = Decimal(task.segment_length)
        frame = np.array([[Decimal(int(i == j)) for j in range(3)] for i in range(3)])
        position = np.array([Decimal(0)] * 3)
        stretch = [Decimal(1)] * task.segments
        if h is not None:
            each = [1 + Decimal(int(x)) / 2**task.elongation_bits for x in h]
            stretch = list(np.repeat(np.array(each), task.sections))
        for i in range(task.segments):
            a = Decimal(int(u[i])) / 2 ** task.fraction_bits[0]
            b = Decimal(int(v[i])) / 2 ** task.fraction_bits[1]
            turn, chord = _segment(a, b)
            position = position + length * stretch[i] * frame.dot(chord)
            frame = frame.dot(turn)
        return frame, position


def _segment(u: Decimal, v: Decimal) -> tuple[np.ndarray, np.ndarray]:
    square = u * u + v * v
    a, b = _series(1, square), _series(2, square)
    turn = np.array(
        [
            [1 - b * v * v, b * u * v, a * v],
            [b * u * v, 1 - b * u * u, -a * u],
            [-a * v, a * u, 1 - b * square],
        ]
    )
    return turn, np.array([b * v, -b * u, a])


def _series(first: int, square: Decimal) -> Decimal:
    """Sum of (-square)^k / (2 k + first)!."""
    term = total = Decimal(1) / first
    k = 0
    while abs(term) > Decimal(10) ** -DIGITS:
        k += 1
        term = -term * square / ((2 * k + first) * (2 * k + first - 1))
        total += term
    return total
