"""The C program that an exported folder's cost is measured with: inputs, outputs and state."""

import can

from ccgen.cost.snapshots import snapshots
from ccgen.export.fields import fields_of
from ccgen.fixedpoint.watch import OUT_AFTER
from ccgen.functions.integer import outputs_of
from ccgen.polynomial import Compiled
from ccgen.resources import template
from ccgen.targets.exported import Exported
from ccgen.targets.inputs import Integers

REPEATS = OUT_AFTER + 1
"""How often an examined snapshot is followed: until what it names is left out, and once more."""

FIRST_FUNCTION = 15
"""Number that the harness notes on AVR before the first of the user's own functions."""


def frames(exported: Exported, counts: Integers) -> list[list[can.Message]]:
    """LENGTHS frames of every snapshot."""
    codec = exported.codec
    numbers = exported.layout.numbers
    return [codec.encode(row, k % numbers) for k, row in enumerate(counts.tolist())]


def source(exported: Exported) -> str:
    """C source: constant inputs, and variables for everything a caller owns."""
    taken = snapshots(exported)
    sent = frames(exported, taken.whole)
    fields = fields_of(exported.joint, exported.layout)
    results = {
        f"cost_{function.name}_{output}": len(row)
        for function in exported.functions.compiled
        for output, row in outputs_of(function).items()
    }
    return template("cost_harness.c.j2").render(
        name=exported.joint.name,
        counts=[[row[field.part] for field in fields] for row in taken.all.tolist()],
        whole=len(taken.whole),
        examined=len(taken.examined),
        repeats=REPEATS,
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
