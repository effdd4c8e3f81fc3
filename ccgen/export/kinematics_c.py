"""The joint's kinematics in single-precision C: CasADi's arithmetic and the templates' context.

The generated C loops over one function that CasADi derives from the segment's transform. Instead of
multiplying 4x4 matrices it advances the frame (X, Y, Z) and the position p directly: with
n = v X - u Y and the chord q = b n + a Z of unit arc length,

    X' = X - v q     Y' = Y + u q     Z' = a n + cos(phi) Z     p' = p + h q

which takes two thirds of the operations and no memory beside the pose. A second function also
yields the segment's two columns of the Jacobian. Everything is a polynomial in phi^2 = u^2 + v^2:

    c = 1/3! - phi^2/5! + ...    d = 1/4! - phi^2/6! + ...
    a = 1 - phi^2 c              b = 1/2 - phi^2 d             cos(phi) = 1 - phi^2 b

of the degree that the angles' format asks for: no square root, no trigonometry, no branch, no
singularity at the straight pose. `ccgen.kinematics_bounds` bounds the result's error.
"""

import math
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ccgen.errors import FormatError
from ccgen.export.casadi_c import Arithmetic, arithmetic
from ccgen.kinematics_bounds import (
    ROUNDING_UNIT,
    TRUNCATION,
    ErrorBounds,
    error_bounds,
    largest_angle,
)

ANGLE_LIMIT = 4.0  # rad a segment: beyond, the series cancel more bits than float has to spare

_ROTATION = [f"pose->rotation[{row}][{column}]" for column in range(3) for row in range(3)]
_POSITION = [f"pose->position[{row}]" for row in range(3)]
_COLUMNS = [
    [f"jacobian[{row}][{column}]" for row in range(6)] for column in ("column_u", "column_v")
]


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


def advance_function(h: float, degrees: Degrees) -> Any:
    """`casadi.Function` (rotation, position, u, v) -> (rotation, position) of one segment.

    Args:
        h: length of the segment, metres.
        degrees: of the polynomials c and d.
    """
    import casadi

    segment = _Segment.of(h, degrees)
    return casadi.Function(
        "advance",
        segment.inputs,
        [segment.rotation, segment.position],
        ["rotation", "position", "u", "v"],
        ["distal_rotation", "distal_position"],
    )


def columns_function(h: float, degrees: Degrees) -> Any:
    """`casadi.Function` of one segment's pose and its two columns of the Jacobian.

    (rotation, position, u, v) -> (rotation, position, column_u, column_v), where the linear part of
    a column is the velocity of the point of the moved body that is at the base's origin: adding
    w x p_tip later gives the tip's, so that one pass suffices.
    """
    import casadi

    segment = _Segment.of(h, degrees)
    columns = [
        casadi.vertcat(linear - casadi.cross(angular, segment.position), angular)
        for linear, angular in segment.velocities
    ]
    return casadi.Function(
        "advance_with_columns",
        segment.inputs,
        [segment.rotation, segment.position, *columns],
        ["rotation", "position", "u", "v"],
        ["distal_rotation", "distal_position", "column_u", "column_v"],
    )


@dataclass(frozen=True)
class _Segment:
    """SX graphs of one segment, from its proximal frame to its distal one."""

    inputs: list[Any]
    rotation: Any
    position: Any
    velocities: list[tuple[Any, Any]]  # (dp, w) for u and v in the base frame

    @classmethod
    def of(cls, h: float, degrees: Degrees) -> "_Segment":
        import casadi

        frame, position = casadi.SX.sym("rotation", 3, 3), casadi.SX.sym("position", 3)
        u, v = casadi.SX.sym("u"), casadi.SX.sym("v")
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
            inputs=[frame, position, u, v],
            rotation=casadi.horzcat(x - v * q, y + u * q, a * n + (1 - square * b) * z),
            position=position + h * q,
            velocities=[(h * (u * k - b * y), x - v * g), (h * (v * k + b * x), y + u * g)],
        )


def _polynomial(first: int, degree: int, square: Any) -> Any:
    """Sum over k <= degree of (-square)^k / (2 k + first)! by Horner's rule."""
    total = 1 / math.factorial(2 * degree + first)
    for k in reversed(range(degree)):
        total = 1 / math.factorial(2 * k + first) - square * total
    return total


def kinematics_context(
    name: str,
    segments: int,
    segment_length: float,
    precision: int,
    fraction_bits: Mapping[str, int],
) -> dict[str, Any]:
    """Values that the templates kinematics.h.j2 and kinematics.c.j2 know as `kinematics`.

    Args:
        name: the joint's name, for messages.
        segments: number of segments.
        segment_length: length of one segment's neutral axis, metres.
        precision: bits of an angle, 16 or 32.
        fraction_bits: of the angles' Q format for "u" and "v".

    Raises:
        FormatError: the angle format reaches further than the kinematics hold.
        ToolError: CasADi's C has an unknown form.
    """
    angle = largest_angle(precision, fraction_bits)
    if angle > ANGLE_LIMIT:
        raise FormatError(
            f"{name}: the angle format reaches {angle:g} rad a segment, the kinematics at most"
            f" {ANGLE_LIMIT:g}; lower range_of_motion or use more segments"
        )
    chosen = degrees(angle)
    pose = [_ROTATION, _POSITION]
    inputs = [*pose, ["u"], ["v"]]
    return {
        "largest_angle": f"{angle:g}",
        "bounds": _printed(error_bounds(segments, segments * segment_length, angle)),
        "advance": _c_function(arithmetic(advance_function(segment_length, chosen), inputs, pose)),
        "columns": _c_function(
            arithmetic(columns_function(segment_length, chosen), inputs, [*pose, *_COLUMNS])
        ),
    }


def _printed(bounds: ErrorBounds) -> dict[str, str]:
    """Two digits, rounded up: a bound must not shrink in print."""

    def up(value: float) -> str:
        digits = math.floor(math.log10(value)) - 1
        return f"{math.ceil(value / 10.0**digits) * 10.0**digits:.1e}"

    return {
        "position": up(bounds.position),
        "rotation": up(bounds.rotation),
        "linear": up(bounds.linear),
        "angular": up(bounds.angular),
    }


def _c_function(code: Arithmetic) -> dict[str, Any]:
    declaration = f"float {', '.join(code.variables)};"
    return {
        "signature": textwrap.wrap(code.signature.replace(",", ", "), width=90),
        "operations": code.operations,
        "inputs": code.inputs,
        "variables": textwrap.wrap(declaration, width=95, subsequent_indent="    "),
        "statements": code.statements,
    }
