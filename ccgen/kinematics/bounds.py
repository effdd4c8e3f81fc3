"""How far the generated single-precision kinematics may lie from double precision.

First-order rounding analysis of the recursion that the generated C runs (`export.kinematics_c`).
With the proximal frame (X, Y, Z), position p and n = v X - u Y, one segment computes

    q = b n + a Z     X' = X - v q     Y' = Y + u q     Z' = a n + cos(phi) Z     p' = p + h q

and, for the Jacobian with g = c n + b Z and k = (2 d - c) n + (c - b) Z,

    w_u = X - v g     w_v = Y + u g     dp_u = h (u k - b Y)     dp_v = h (v k + b X)

The exact segment only rotates an error that it receives, so the Frobenius norm of the rotation's
error grows by no more than a constant a segment, and the position's error by the segment length
times the rotation's error so far. Fused multiply-adds leave out roundings: the bounds hold with and
without contraction. Angles are integers scaled by a power of two, converted to float with at most
one rounding; every argument is the largest magnitude over both axes.

Numbers named `*_error` are in units of the rounding unit 2^-24.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

ROUNDING_UNIT = 2.0**-24
TRUNCATION = 0.25  # what leaving out the series' higher terms may cost, in rounding units

_TERMS = 60
_SECOND_ORDER = 1.01  # products of roundings: below 64 segments x 2^-24 x the local error


@dataclass(frozen=True)
class ErrorBounds:
    """Bounds over all angles that the format holds, each a 2-norm (Frobenius for the rotation)."""

    position: float  # metres, every segment's distal end
    rotation: float  # 1, every segment's distal end
    linear: float  # metres per radian (h: per share), every column of the tip Jacobian
    angular: float  # 1, every column of the tip Jacobian


def largest_angle(precision: int, fraction_bits: Mapping[str, int]) -> float:
    """Full scale of the coarser of the bending axes' angle formats, radians."""
    return max(_full_scale(precision, bits) for axis, bits in fraction_bits.items() if axis != "h")


def largest_elongation(precision: int, fraction_bits: Mapping[str, int]) -> float | None:
    """Full scale of the elongation's format, share of the length; None where there is none."""
    return _full_scale(precision, fraction_bits["h"]) if "h" in fraction_bits else None


def _full_scale(precision: int, fraction_bits: int) -> float:
    return float(2.0 ** (precision - 1 - fraction_bits))


def error_bounds(
    segments: int, length: float, angle: float, elongation: float | None = None
) -> ErrorBounds:
    """Bounds on the errors of the generated poses and Jacobian.

    A segment that elongates has the length h (1 + e), which costs three roundings.

    Args:
        segments: number of segments.
        length: length of the whole joint's neutral axis at no elongation, metres.
        angle: largest magnitude that the angle format holds, radians.
        elongation: the same of the elongation, share of the length; None where there is none.
    """
    local = _Local.of(angle)
    length *= 1.0 + (elongation or 0.0)
    h = length / segments
    stretch = 0.0 if elongation is None else 3.0

    def position(i: int) -> float:
        """Error after i segments: rotation so far, the step's own error, the running sum."""
        chord = local.chord + 2 + stretch
        return h * (local.frame * i * (i - 1) / 2 + i * chord + i * (i + 1) / 2)

    def linear(i: int) -> float:
        """Error of segment i's columns: dp + w x (p_tip - p_end), the cross products apart."""
        own = h * (local.linear + (i * local.frame + stretch) * local.linear_norm)
        turned = (i * local.frame + local.angular) * (segments - 1 - i) * h
        crossed = (1 + math.sqrt(2)) * (length + (i + 1) * h)
        return own + turned + crossed + 2 * (length + h) + position(i + 1) + position(segments)

    # A column of elongation sums h q over a section: what a position does, and less.
    scale = _SECOND_ORDER * ROUNDING_UNIT
    return ErrorBounds(
        position=scale * position(segments),
        rotation=scale * segments * local.frame,
        linear=scale * max(position(segments), *(linear(i) for i in range(segments))),
        angular=scale * ((segments - 1) * local.frame + local.angular),
    )


@dataclass(frozen=True)
class _Local:
    """Errors that one segment adds to exact input, in rounding units."""

    chord: float  # of q
    frame: float  # of the distal frame, Frobenius norm
    angular: float  # of w_u, w_v
    linear: float  # of dp_u / h, dp_v / h
    linear_norm: float  # bound on |dp_u| / h, |dp_v| / h themselves

    @classmethod
    def of(cls, angle: float) -> "_Local":
        """Follow the recursion above, operation by operation, for |u|, |v| <= angle.

        Uses |n| = phi, |q| <= 1, |g| <= 1/2, |a|, |cos| <= 1, b <= 1/2, c <= 1/6, d <= 1/24. A sum
        x + y of vectors costs |x + y|, a product s x costs |s x| plus the error of s times |x|.
        """
        phi = math.sqrt(2) * angle
        cosine, a, b, c, d = (_series_error(first, phi) for first in range(5))
        n = (2 * math.sqrt(2) + 1) * phi
        chord = (b * phi + n / 2 + phi / 2) + (a + 1) + 1
        x_axis = angle * (chord + 2) + 1
        z_axis = (a * phi + n + phi) + (cosine + 1) + 1
        mean = (c * phi + n / 6 + phi / 6) + (b + 1 / 2) + 1 / 2
        db, da = (2 * d + c + 1 / 4), (c + b + 2 / 3)
        k_norm = phi / 4 + 2 / 3
        k = (db * phi + n / 4 + phi / 4) + (da + 2 / 3) + k_norm
        linear_norm = angle * k_norm + 1 / 2
        return cls(
            chord=chord,
            frame=math.sqrt(2 * x_axis**2 + z_axis**2),
            angular=angle * (mean + 1) + 1,
            linear=angle * (k + 2 * k_norm) + (b + 1 / 2) + linear_norm + 2 * linear_norm,
            linear_norm=linear_norm,
        )


def _series_error(first: int, phi: float) -> float:
    """Error of sum_k (-phi^2)^k / (2 k + first)! by Horner's rule.

    Term k passes 2 k + 1 roundings, its coefficient one unless exact, and phi^2 carries four.
    The truncation enters the results of c and d (first 3 and 4) through at least a factor phi.
    """
    total = TRUNCATION / (phi if first > 2 else 1.0)
    for k in range(_TERMS):
        inexact = 2 * k + first > 2
        total += (6 * k + 1 + inexact) * phi ** (2 * k) / math.factorial(2 * k + first)
    return total
