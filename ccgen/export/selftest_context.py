"""What the templates know of the self-test: vectors with the right angles, checksums of blocks."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ccgen.can.layout import FrameLayout
from ccgen.export.fields import Field, fields_of
from ccgen.export.model_context import relative_arrays
from ccgen.export.vectors import outcome
from ccgen.fixedpoint import FixedPointModel
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.fixedpoint.model import Integers
from ccgen.fixedpoint.pose import PoseModel, pose_inputs
from ccgen.joint import Joint
from ccgen.sensing.counts import counts
from ccgen.shapes import Shapes

SHAPE_VECTORS = 8
BLOCKS = 8
BLOCK_SNAPSHOTS = 64


def selftest_context(
    joint: Joint, guarded: GuardedModel, poses: PoseModel, layout: FrameLayout, shapes: Shapes
) -> dict[str, Any]:
    """Vectors with the right angles, and checksums of drawn blocks."""
    model = guarded.model
    readings = model.readings
    arrays = {"minimum": readings.minimum, "maximum": readings.maximum}
    if readings.relative is not None:
        arrays |= relative_arrays(readings.relative)
    state = joint.precision // 8 * (2 * readings.sensors + model.values)
    return {
        "vectors": _vectors(joint, model, poses, fields_of(joint, layout), shapes),
        "drawn": {key: values.tolist() for key, values in arrays.items()},
        "checksums": [outcome(guarded, seed, BLOCK_SNAPSHOTS).checksum for seed in range(BLOCKS)],
        "block_snapshots": BLOCK_SNAPSHOTS,
        "stack_bytes": 100 * math.ceil((state + 150) / 100),
    }


def _vectors(
    joint: Joint,
    model: FixedPointModel,
    poses: PoseModel,
    fields: Sequence[Field],
    shapes: Shapes,
) -> list[dict[str, Any]]:
    rows = _readings(joint, model, shapes)
    values = model.estimate(rows)
    parts = list(model.split(values).values())
    tips = poses.entries(*pose_inputs(model, values))
    return [
        {
            "counts": [row[field.part].tolist() for field in fields],
            "angles": [part[k].tolist() for part in parts],
            "rotation": tips[k, :9].tolist(),
            "position": tips[k, 9:].tolist(),
        }
        for k, row in enumerate(rows)
    ]


def _readings(joint: Joint, model: FixedPointModel, shapes: Shapes) -> Integers:
    """Readings of shapes, and the corners with the most and the least of everything."""
    every = slice(None, None, max(1, len(shapes) // SHAPE_VECTORS))
    u, v, h = (part[every][:SHAPE_VECTORS] for part in (shapes.u, shapes.v, shapes.h))
    around = [group.around() for group in model.groups]
    bent = counts(joint, around, Shapes(u, v[::-1], h, ("shapes",) * len(u)))
    ends = [
        np.concatenate(
            [(one.minimum, one.maximum)[(k + upper) % 2] for k, one in enumerate(around)]
        )
        for upper in (0, 1)
    ]
    return np.concatenate([bent, ends])
