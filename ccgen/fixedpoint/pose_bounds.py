"""How far integer poses may lie from exact ones: induction over the segments.

With R the exact frame after some segments, S the integers' one, T the exact turn of the next
segment and T' its truncated series (the integers' polynomial is linear in the frame), the next
difference is

    S T' + E - R T = (S - R) T + S (T' - T) + E

where E holds the roundings, each proven over all frames whose entries stay within 1 plus a
little. A rotation keeps the Frobenius norm of the first term, so that norm grows by no more than a
constant a segment; the entries then do stay there, which closes the circle. The chord of a segment
errs in the same way, by a vector of no more than the frame's error, and the position by their sum.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ccgen.kinematics.symbolic import TurnDegrees, turn_series

FRAME_MARGIN = Fraction(1, 2**12)
"""What entries of a frame may exceed 1 by."""

_DIGITS = 160


@dataclass(frozen=True)
class Roundings:
    """Norms of what the integers of one segment round away."""

    frame: Fraction
    chord: Fraction


@dataclass(frozen=True)
class ChainBounds:
    """Largest errors after all segments.

    Attributes:
        frame: Frobenius norm.
        chords: norm of the sum of all chords, in lengths of a segment.
    """

    frame: Fraction
    chords: Fraction


def chain_bounds(
    segments: int, angle: Fraction, degrees: TurnDegrees, roundings: Roundings
) -> ChainBounds:
    """Bounds for all angles up to one in magnitude, of either axis.

    Args:
        segments: of the chain.
        angle: radians.
        degrees: of the series.
        roundings: of one segment.
    """
    turn, chord = truncations(angle, degrees)
    frame = chords = Fraction(0)
    for _ in range(segments):
        chords = raised(chords + frame + (1 + frame) * chord + roundings.chord)
        frame = raised(frame + (1 + frame) * turn + roundings.frame)
    return ChainBounds(frame, chords)


def truncations(angle: Fraction, degrees: TurnDegrees) -> tuple[Fraction, Fraction]:
    """Norms of what a segment's turn (Frobenius) and chord lack without the series' other terms.

    In the frame that is turned, where Z is of length 1 and n, at right angles to it, of length phi.
    The first term left out of a series, whose signs alternate, bounds what it lacks, as long as
    terms fall.
    """
    square = 2 * angle**2
    phi = root(square)
    longer = TurnDegrees(degrees.alpha + 1, degrees.eta + 1, degrees.kappa + 1)
    inexact = Fraction(3 ** math.ceil(phi), 2**52)  # coefficients are rounded to doubles
    alpha, eta, kappa = (
        abs(terms[-1]) * square ** len(terms) + inexact for terms in turn_series(longer)
    )
    chord = alpha * (1 + phi / 4) + eta * phi
    folded = (3 + phi) * alpha + kappa
    return raised(norm([phi * chord, folded])), raised(chord)


def norm(parts: Sequence[Fraction]) -> Fraction:
    """Length of a vector, rounded up."""
    return root(sum((part * part for part in parts), Fraction(0)))


def root(value: Fraction) -> Fraction:
    """Square root, rounded up."""
    scaled = -(-value.numerator * 4**_DIGITS // value.denominator)
    return Fraction(math.isqrt(scaled) + 1, 2**_DIGITS)


def raised(value: Fraction) -> Fraction:
    """A rational of bounded length that is not below another."""
    return Fraction(-(-value.numerator * 2**_DIGITS // value.denominator), 2**_DIGITS)
