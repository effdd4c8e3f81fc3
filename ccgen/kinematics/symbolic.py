"""The segment's kinematics as CasADi functions, polynomial in phi^2.

Instead of multiplying 4x4 matrices they advance the frame (X, Y, Z) and the position p directly:
with n = v X - u Y and the chord q = b n + a Z of unit arc length,

    X' = X - v q     Y' = Y + u q     Z' = a n + cos(phi) Z     p' = p + h q

which takes two thirds of the operations and no memory beside the pose. A second function also
yields the segment's two columns of the Jacobian. Everything is a polynomial in phi^2 = u^2 + v^2:

    c = 1/3! - phi^2/5! + ...    d = 1/4! - phi^2/6! + ...
    a = 1 - phi^2 c              b = 1/2 - phi^2 d             cos(phi) = 1 - phi^2 b

of the degree that the angles' format asks for: no square root, no trigonometry, no branch, no
singularity at the straight pose. `ccgen.kinematics.bounds` bounds the result's error.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ccgen.kinematics.bounds import ROUNDING_UNIT, TRUNCATION


@dataclass(frozen=True)
class Degrees:
    """Degrees in phi^2 of the polynomials c and d."""

    c: int
    d: int


def degrees(angle: float) -> Degrees:
    """Least degrees whose truncation stays below float rounding for |u|, |v| <= angle.

    The first term left out bounds the truncation. It enters the pose and the Jacobian through c
    times at most max(phi, phi^2) and through d times at most max(phi, phi^4).
    """
    phi = math.sqrt(2) * angle
    return Degrees(
        c=_degree(3, phi, max(phi, phi**2)),
        d=_degree(4, phi, max(phi, phi**4)),
    )


def _degree(first: int, phi: float, factor: float) -> int:
    degree = 0
    while factor * phi ** (2 * degree + 2) / math.factorial(2 * degree + 2 + first) > (
        TRUNCATION * ROUNDING_UNIT
    ):
        degree += 1
    return degree


def advance_function(h: float | None, degrees: Degrees) -> Any:
    """`casadi.Function` (rotation, position, u, v) -> (rotation, position) of one segment.

    Args:
        h: length of the segment, metres; None for a further input, behind v.
        degrees: of the polynomials c and d.
    """
    import casadi

    segment = _Segment.of(h, degrees)
    return casadi.Function(
        "advance",
        segment.inputs,
        [segment.rotation, segment.position],
        segment.names,
        ["distal_rotation", "distal_position"],
    )


def columns_function(h: float | None, degrees: Degrees) -> Any:
    """`casadi.Function` of one segment's pose and its two columns of the Jacobian.

    (rotation, position, u, v) -> (rotation, position, column_u, column_v), where the linear part of
    a column is the velocity of the point of the moved body that is at the base's origin: adding
    w x p_tip later gives the tip's, so that one pass suffices. Where the length is an input, the
    chord of unit arc length in the base frame follows: the velocity of the distal end for a unit
    rate of the length.

    Args:
        h, degrees: as of `advance_function`.
    """
    import casadi

    segment = _Segment.of(h, degrees)
    columns = [
        casadi.vertcat(linear - casadi.cross(angular, segment.position), angular)
        for linear, angular in segment.velocities
    ]
    chords = {"chord": segment.chord} if h is None else {}
    return casadi.Function(
        "advance_with_columns",
        segment.inputs,
        [segment.rotation, segment.position, *columns, *chords.values()],
        segment.names,
        ["distal_rotation", "distal_position", "column_u", "column_v", *chords],
    )


@dataclass(frozen=True)
class _Segment:
    """SX graphs of one segment, from its proximal frame to its distal one."""

    inputs: list[Any]
    names: list[str]
    rotation: Any
    position: Any
    velocities: list[tuple[Any, Any]]  # (dp, w) for u and v in the base frame
    chord: Any  # of unit arc length

    @classmethod
    def of(cls, length: float | None, degrees: Degrees) -> "_Segment":
        import casadi

        frame, position = casadi.SX.sym("rotation", 3, 3), casadi.SX.sym("position", 3)
        u, v = casadi.SX.sym("u"), casadi.SX.sym("v")
        h: Any = casadi.SX.sym("h") if length is None else length
        inputs: dict[str, Any] = {"rotation": frame, "position": position, "u": u, "v": v}
        if length is None:
            inputs["h"] = h
        x, y, z = casadi.horzsplit(frame)
        square = u * u + v * v
        c = _polynomial(3, degrees.c, square)
        d = _polynomial(4, degrees.d, square)
        a, b = 1 - square * c, 0.5 - square * d
        n = v * x - u * y
        q = b * n + a * z
        g = c * n + b * z
        k = (2 * d - c) * n + (c - b) * z  # from da/du = u (c - b), db/du = u (2 d - c)
        return cls(
            inputs=list(inputs.values()),
            names=list(inputs),
            rotation=casadi.horzcat(x - v * q, y + u * q, a * n + (1 - square * b) * z),
            position=position + h * q,
            velocities=[(h * (u * k - b * y), x - v * g), (h * (v * k + b * x), y + u * g)],
            chord=q,
        )


def _polynomial(first: int, degree: int, square: Any) -> Any:
    """Sum over k <= degree of (-square)^k / (2 k + first)! by Horner's rule."""
    total = 1 / math.factorial(2 * degree + first)
    for k in reversed(range(degree)):
        total = 1 / math.factorial(2 * k + first) - square * total
    return total


@dataclass(frozen=True)
class TurnDegrees:
    """How many terms the series of a turn in integers have; see `turn_function`.

    Attributes:
        alpha: from phi^2 on.
        eta: from phi^4 on.
        kappa: from phi^4 on.
    """

    alpha: int
    eta: int
    kappa: int


def turn_function(degrees: TurnDegrees) -> Any:
    """`casadi.Function` (frame, u, v) -> (distal, chord) of one segment, made for integers.

    The frame's columns are X, Y, Z; the chord q is that of unit arc length. With n = v X - u Y,

        q  = Z + n / 2 - alpha Z - (alpha / 4 + eta) n         alpha = 1 - sin(phi) / phi
        Z' = Z + n - (3 alpha - kappa) Z - alpha n             X' = X - v q,  Y' = Y + u q

    where eta and kappa, what the coefficients lack of multiples of alpha, begin with phi^4. What is
    small beside what it is added to is computed apart, so that few bits of it suffice: all but
    alpha (Z + n / 4), which q and Z' share.
    """
    import casadi

    frame = casadi.SX.sym("frame", 3, 3)
    u, v = casadi.SX.sym("u"), casadi.SX.sym("v")
    x, y, z = casadi.horzsplit(frame)
    square = u * u + v * v
    alpha, eta, kappa = (_series(terms, square) for terms in turn_series(degrees))
    n = v * x - u * y
    shared = alpha * (z + n / 4)
    rise = n / 2 - shared
    q = z + rise - eta * n
    folded = q + (rise - (shared + ((alpha / 4 - eta) * n - kappa * z)))
    distal = casadi.horzcat(x - v * q, y + u * q, folded)
    return casadi.Function(
        "turn", [frame, u, v], [distal, q], ["frame", "u", "v"], ["distal", "chord"]
    )


def turn_series(degrees: TurnDegrees) -> tuple[list[Fraction], list[Fraction], list[Fraction]]:
    """Coefficients of phi^2, phi^4, ... in alpha, eta and kappa of `turn_function`."""
    factorial = math.factorial
    alpha = [Fraction((-1) ** k, factorial(2 * k + 3)) for k in range(degrees.alpha)]
    eta = [-Fraction((-1) ** k * k, 2 * factorial(2 * k + 4)) for k in range(degrees.eta + 1)]
    kappa = [-Fraction((-1) ** k * 2 * k, factorial(2 * k + 3)) for k in range(degrees.kappa + 1)]
    return alpha, eta, kappa


def _series(terms: list[Fraction], square: Any) -> Any:
    """Sum over k of terms[k] square^(k + 1) by Horner's rule; coefficients become doubles."""
    total: Any = 0
    for term in reversed(terms):
        total = square * (float(term) + total)
    return total


def place_function(segment_length: float, sections: int, elongates: bool) -> Any:
    """`casadi.Function` (sums[, h]) -> position, from the chords of each section added up.

    Args:
        segment_length: without elongation, metres.
        sections: number of sections, columns of `sums`.
        elongates: whether there is an `h`, the elongation of each section.
    """
    import casadi

    sums, h = casadi.SX.sym("sums", 3, sections), casadi.SX.sym("h", sections)
    columns = casadi.horzsplit(sums)
    if elongates:
        columns = [column + column * h[s] for s, column in enumerate(columns)]
    total = columns[0]
    for column in columns[1:]:
        total = total + column
    inputs, names = ([sums, h], ["sums", "h"]) if elongates else ([sums], ["sums"])
    return casadi.Function("place", inputs, [segment_length * total], names, ["position"])


def columns_of_turn(degrees: Degrees) -> Any:
    """`casadi.Function` (frame, u, v) -> (turn_u, turn_v, chord_u, chord_v), made for integers.

    How one segment moves what follows it: angular velocities for a unit rate of u and of v, and
    the velocities of its chord of unit arc length; with c, d, b and n of the module

        g = c n + b Z       k = (2 d - c) n + (c - b) Z
        turn_u = X - v g    turn_v = Y + u g    chord_u = u k - b Y    chord_v = v k + b X
    """
    import casadi

    frame = casadi.SX.sym("frame", 3, 3)
    u, v = casadi.SX.sym("u"), casadi.SX.sym("v")
    x, y, z = casadi.horzsplit(frame)
    square = u * u + v * v
    c, d = _quotients(3, degrees.c, square), _quotients(4, degrees.d, square)
    less_b = square * d
    n = v * x - u * y
    g = z / 2 + (c * n - less_b * z)
    k = (2 * d - c) * n + (c + less_b - 0.5) * z
    chord_u = u * k - (y / 2 - less_b * y)
    chord_v = v * k + (x / 2 - less_b * x)
    return casadi.Function(
        "columns",
        [frame, u, v],
        [x - v * g, y + u * g, chord_u, chord_v],
        ["frame", "u", "v"],
        ["turn_u", "turn_v", "chord_u", "chord_v"],
    )


def column_function(segment_length: float, elongates: bool) -> Any:
    """`casadi.Function` (turn, chord, lever[, h]) -> linear: the tip's velocity in metres.

    Args:
        segment_length: without elongation, metres.
        elongates: whether there is an `h`, the elongation of the segment's section.
    """
    import casadi

    turn, chord, lever = (casadi.SX.sym(name, 3) for name in ("turn", "chord", "lever"))
    h = casadi.SX.sym("h")
    moved = chord + chord * h if elongates else chord
    linear = segment_length * moved + casadi.cross(turn, lever)
    inputs, names = [turn, chord, lever], ["turn", "chord", "lever"]
    if elongates:
        inputs, names = [*inputs, h], [*names, "h"]
    return casadi.Function("column", inputs, [linear], names, ["linear"])


def stretch_function(segment_length: float) -> Any:
    """`casadi.Function` sum -> linear: the tip's velocity for a unit rate of an elongation.

    Args:
        segment_length: without elongation, metres.
    """
    import casadi

    total = casadi.SX.sym("sum", 3)
    return casadi.Function("stretch", [total], [segment_length * total], ["sum"], ["linear"])


def _quotients(first: int, degree: int, square: Any) -> Any:
    """`_polynomial` by Horner's rule with divisions by whole numbers alone."""
    total: Any = 1
    for k in reversed(range(1, degree + 1)):
        total = 1 - square * total / ((2 * k + first) * (2 * k + first - 1))
    return total / math.factorial(first)
