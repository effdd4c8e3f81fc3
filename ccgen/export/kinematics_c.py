"""The joint's kinematics in single-precision C: CasADi's arithmetic and the templates' context.

The generated C loops over one function that CasADi derives from the segment's transform, see
`ccgen.kinematics.symbolic`; `ccgen.kinematics.bounds` bounds the result's error.
"""

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from ccgen.digits import rounded_up
from ccgen.errors import FormatError
from ccgen.export.casadi_c import Arithmetic, arithmetic
from ccgen.export.literals import float_literal
from ccgen.kinematics.bounds import (
    ErrorBounds,
    error_bounds,
    largest_angle,
    largest_elongation,
)
from ccgen.kinematics.symbolic import advance_function, columns_function, degrees

ANGLE_LIMIT = 4.0  # rad a segment: beyond, the series cancel more bits than float has to spare

_ROTATION = [f"pose->rotation[{row}][{column}]" for column in range(3) for row in range(3)]
_POSITION = [f"pose->position[{row}]" for row in range(3)]


def kinematics_context(
    name: str,
    segments: int,
    segment_length: float,
    precision: int,
    fraction_bits: Mapping[str, int],
    sections: Sequence[int] = (),
) -> dict[str, Any]:
    """Values that the templates kinematics.h.j2 and kinematics.c.j2 know as `kinematics`.

    Args:
        name: where the joint stands, for messages.
        segments: number of segments.
        segment_length: length of one segment's neutral axis at no elongation, metres.
        precision: bits of an angle, 16 or 32.
        fraction_bits: of the Q formats of the axes that are estimated.
        sections: segments of each section that elongates by itself, where "h" is estimated.

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
    elongation = largest_elongation(precision, fraction_bits)
    bounds = error_bounds(segments, segments * segment_length, angle, elongation)
    length = segment_length if elongation is None else None
    more = [] if elongation is None else [["h"]]
    chords = [] if elongation is None else [[f"chord[{row}]" for row in range(3)]]
    chosen = degrees(angle)
    pose = [_ROTATION, _POSITION]
    inputs = [*pose, ["u"], ["v"], *more]
    # A bend that is not estimated is none, and its columns of the Jacobian are left out.
    columns = [
        [f"jacobian[{row}][column_{axis}]" for row in range(6)]
        if axis in fraction_bits
        else [f"unused[{row}]" for row in range(6)]
        for axis in "uv"
    ]
    return {
        "largest_angle": f"{angle:g}",
        "bounds": _printed(bounds),
        "segment_length": float_literal(segment_length),
        "section_of": [k for k, size in enumerate(sections) for _ in range(size)],
        "largest_elongation": None if elongation is None else f"{elongation:g}",
        "advance": _c_function(arithmetic(advance_function(length, chosen), inputs, pose)),
        "columns": _c_function(
            arithmetic(columns_function(length, chosen), inputs, [*pose, *columns, *chords])
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
