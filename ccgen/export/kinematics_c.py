"""The joint's kinematics in single-precision C: CasADi's arithmetic and the templates' context.

The generated C loops over one function that CasADi derives from the segment's transform, see
`ccgen.kinematics.symbolic`; `ccgen.kinematics.bounds` bounds the result's error.
"""

import textwrap
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from ccgen.digits import rounded_up
from ccgen.errors import FormatError
from ccgen.export.casadi_c import Arithmetic, arithmetic
from ccgen.kinematics.bounds import ErrorBounds, error_bounds, largest_angle
from ccgen.kinematics.symbolic import advance_function, columns_function, degrees

ANGLE_LIMIT = 4.0  # rad a segment: beyond, the series cancel more bits than float has to spare

_ROTATION = [f"pose->rotation[{row}][{column}]" for column in range(3) for row in range(3)]
_POSITION = [f"pose->position[{row}]" for row in range(3)]
_COLUMNS = [
    [f"jacobian[{row}][{column}]" for row in range(6)] for column in ("column_u", "column_v")
]


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
    return {key: f"{rounded_up(value, 2):.1e}" for key, value in asdict(bounds).items()}


def _c_function(code: Arithmetic) -> dict[str, Any]:
    declaration = f"float {', '.join(code.variables)};"
    return {
        "signature": textwrap.wrap(code.signature.replace(",", ", "), width=90),
        "operations": code.operations,
        "inputs": code.inputs,
        "variables": textwrap.wrap(declaration, width=95, subsequent_indent="    "),
        "statements": code.statements,
    }
