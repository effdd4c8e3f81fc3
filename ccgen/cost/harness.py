"""The C program that an exported folder's cost is measured with: inputs, outputs and state."""

from collections.abc import Sequence

import can
import numpy as np

from ccgen.sensing.counts import corner_counts, random_counts
from ccgen.targets.exported import Exported
from ccgen.targets.inputs import Integers, shape_counts

SHAPES = 2
CORNERS = 2
DRAWN = 1


def snapshots(exported: Exported) -> Integers:
    """Counts to measure with: shapes, corners of the ranges, drawn; shape (k, nu + nv)."""
    axes = (exported.model.u, exported.model.v)
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
    modulus = exported.layout.counter_modulus
    return [codec.encode(row, k % modulus) for k, row in enumerate(counts.tolist())]


def source(exported: Exported) -> str:
    """C source: constant inputs, and variables for everything a caller owns."""
    counts = snapshots(exported)
    sent = frames(exported, counts)
    name, split = exported.joint.name, exported.model.u.sensors
    rows = ",\n    ".join(
        f"{{{{{_listed(row[:split])}}}, {{{_listed(row[split:])}}}}}" for row in counts.tolist()
    )
    messages = ",\n    ".join(_frame(message) for group in sent for message in group)
    return _SOURCE.format(
        name=name, snapshots=len(counts), counts=rows, frames=len(sent[0]), messages=messages,
        cycle_us=exported.layout.cycle_us,
    )  # fmt: skip


def _listed(values: Sequence[int]) -> str:
    return ", ".join(map(str, values))


def _frame(message: can.Message) -> str:
    flags = f"{int(message.is_extended_id)}, {int(message.is_fd)}, 0, 0"
    return (
        f"{{{message.arbitration_id}u, {flags}, {len(message.data)}, {{{_listed(message.data)}}}}}"
    )


_SOURCE = """\
#include "{name}_can.h"
#include "{name}_kinematics.h"

#define SNAPSHOTS {snapshots}
#define FRAMES {frames}
#define CYCLE_US {cycle_us}u

const {name}_counts_t cost_counts[SNAPSHOTS] = {{
    {counts},
}};
const ccgen_frame_t cost_frames[SNAPSHOTS * FRAMES] = {{
    {messages},
}};
{name}_t cost_joint;
{name}_angles_t cost_angles;
{name}_pose_t cost_pose;
{name}_node_t cost_node;
ccgen_frame_t cost_frame;

#if defined(__AVR__)
#include <avr/io.h>
#include <avr/interrupt.h>
#include <avr/sleep.h>

/* The emulator notes the cycle at which a number is written; sleep with interrupts off ends it. */
#define NOTE(number) (GPIOR0 = (number))

static void measure_snapshot(const uint8_t k) {{
    const uint32_t now = k * (uint32_t)CYCLE_US;
    NOTE(1);
    (void){name}_estimate(&cost_joint, &cost_counts[k], &cost_angles);
    NOTE(2);
    (void){name}_tip_pose(&cost_angles, &cost_pose);
    for (uint8_t i = 0; i < FRAMES; ++i) {{
        NOTE(3);
        (void){name}_node_receive(&cost_node, &cost_frames[k * FRAMES + i], now);
    }}
    int more;
    do {{
        NOTE(4);
        more = {name}_node_transmit(&cost_node, now, &cost_frame);
    }} while (more == 1);
    NOTE(5);
    (void){name}_node_receive(&cost_node, &cost_frames[k * FRAMES], now);
    NOTE(6);
}}

int main(void) {{
    (void){name}_init(&cost_joint);
    (void){name}_node_init(&cost_node);
    NOTE(7);
    NOTE(8);
    for (uint8_t k = 0; k < SNAPSHOTS; ++k) {{
        measure_snapshot(k);
    }}
    cli();
    sleep_enable();
    sleep_cpu();
}}
#endif
"""
