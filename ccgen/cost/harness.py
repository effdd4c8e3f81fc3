"""The C program that an exported folder's cost is measured with: inputs, outputs and state."""

import can
import numpy as np

from ccgen.export.fields import fields_of
from ccgen.functions.integer import outputs_of
from ccgen.polynomial import Compiled
from ccgen.resources import template
from ccgen.sensing.counts import corner_counts, random_counts
from ccgen.targets.exported import Exported
from ccgen.targets.inputs import Integers, shape_counts

SHAPES = 2
CORNERS = 2
DRAWN = 1

FIRST_FUNCTION = 11
"""Number that the harness notes on AVR before the first of the user's own functions."""


def snapshots(exported: Exported) -> Integers:
    """Counts to measure with: shapes, corners of the ranges, drawn; shape (k, n)."""
    axes = [group.around() for group in exported.model.groups]
    shapes, corners = shape_counts(exported), corner_counts(axes)
    return np.concatenate(
        [
            shapes[:: max(1, len(shapes) // SHAPES)][:SHAPES],
            corners[:: max(1, len(corners) - 1)][:CORNERS],
            random_counts(axes, DRAWN, 0),
        ]
    )


def frames(exported: Exported, counts: Integers) -> list[list[can.Message]]:
    """LENGTHS frames of every snapshot."""
    codec = exported.codec
    numbers = exported.layout.numbers
    return [codec.encode(row, k % numbers) for k, row in enumerate(counts.tolist())]


def source(exported: Exported) -> str:
    """C source: constant inputs, and variables for everything a caller owns."""
    counts = snapshots(exported)
    sent = frames(exported, counts)
    fields = fields_of(exported.joint, exported.layout)
    results = {
        f"cost_{function.name}_{output}": len(row)
        for function in exported.functions.compiled
        for output, row in outputs_of(function).items()
    }
    return template("cost_harness.c.j2").render(
        name=exported.joint.name,
        counts=[[row[field.part] for field in fields] for row in counts.tolist()],
        frames=len(sent[0]),
        messages=[message for group in sent for message in group],
        cycle_us=exported.layout.cycle_us,
        health_id=exported.layout.frames_of("health")[0].id,
        functions=[
            {"name": function.name, "variables": variables}
            for function, variables in results_of(exported)
        ],
        results=results,
        first_function=FIRST_FUNCTION,
    )


def results_of(exported: Exported) -> list[tuple[Compiled, list[str]]]:
    """The user's own functions, each with the variables that it writes its outputs to."""
    return [
        (function, [f"cost_{function.name}_{output}" for output in outputs_of(function)])
        for function in exported.functions.compiled
    ]
