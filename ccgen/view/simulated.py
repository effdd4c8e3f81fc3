"""A simulated joint as its own sensors see it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ccgen.estimation.estimate import normalised_readings
from ccgen.fixedpoint.fitted import Fit
from ccgen.joint import Joint
from ccgen.sensing.simulation import Simulation
from ccgen.view.sight import Bends, Sight


def as_found(fit: Fit) -> Joint:
    """The joint with the gains and zeros that its estimate uses."""
    return replace(fit.sensed, sensors=fit.sensors)


def simulated_sights(fit: Fit, shapes: Sequence[Simulation]) -> list[Sight]:
    """What the fitted weights make of the counts at each shape, beside the shape itself.

    Args:
        fit: of the joint.
        shapes: simulated, of `as_found`.

    Returns:
        A sight a shape, all at second 0.
    """
    joint = as_found(fit)
    counts = np.array([shape.counts for shape in shapes], dtype=np.float64)
    for row, shape in zip(counts, shapes, strict=True):
        row[list(shape.out_of_range)] = np.nan
    found = fit.estimate(counts)
    readings = normalised_readings(joint, joint.sensors, counts)
    sights = []
    for k, shape in enumerate(shapes):
        bends = {"u": found.u[k], "v": found.v[k], "h": found.h[k]}
        lost = tuple(axis for axis in joint.axes if np.isnan(bends[axis]).any())
        sights.append(
            Sight(
                t=0.0,
                estimate=Bends(**{axis: np.nan_to_num(x) for axis, x in bends.items()}),
                readings=readings[k],
                truth=Bends(shape.u, shape.v, shape.h),
                lost=lost,
                missing=tuple(joint.sensors[j].name for j in shape.out_of_range),
            )
        )
    return sights
