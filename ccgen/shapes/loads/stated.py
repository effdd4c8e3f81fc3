"""The shape of a joint under stated loads."""

from __future__ import annotations

import numpy as np

from ccgen.errors import ReachError
from ccgen.joint.loads import StatedLoads
from ccgen.shapes.library import Shapes
from ccgen.shapes.loads import mesh as meshes
from ccgen.shapes.loads.continuation import LIMITED, REACHED, STEEPEST, Limit, Raised, raise_loads
from ccgen.shapes.loads.equilibrium import Array, DeadLoads

_ELEMENTS = 72
"""At least so many: angles are right to 0.01 % of the largest."""


def shape_under(loads: StatedLoads, sections: tuple[int, ...], length: float) -> Shapes:
    """Raise stated loads from zero: one shape, of the source "loads".

    Args:
        loads: what acts on the joint.
        sections: segments of each part that elongates by itself.
        length: of the joint without elongation, metres.

    Raises:
        ReachError: loads that buckle the joint, or bend a segment by more than 90 degrees.
    """
    elongation = np.array(loads.elongation or (0.0,) * len(sections))
    stiffness = loads.stiffness * np.array(loads.stiffness_profile)[:, None]
    by_segment = np.repeat(elongation, sections)[:, None]
    mesh = meshes.cut(sum(sections), _ELEMENTS, length, stiffness, by_segment)
    limit = Limit(mesh.starts, np.array([STEEPEST]))
    raised = raise_loads(
        mesh.rods, meshes.no_loads(mesh), _dead_loads(mesh, loads, length), limit, mesh.straight
    )
    u, v = meshes.segment_angles(mesh, raised.angles)
    _check(raised, u[0], v[0], loads.source)
    return Shapes(u, v, elongation[None], ("loads",))


def _dead_loads(mesh: meshes.Mesh, loads: StatedLoads, length: float) -> DeadLoads:
    total = (
        meshes.actuated(mesh, _column(loads.actuation))
        + meshes.moment(mesh, _column(loads.tip_moment))
        + meshes.at_tip(mesh, _column(loads.tip_force))
        + meshes.spread(mesh, _column(loads.distributed))
    )
    for contact in loads.contacts:
        place = np.array([contact.at / length])
        total = total + meshes.contact(mesh, place, _column(contact.force))
    return total


def _column(values: tuple[float, ...]) -> Array:
    return np.array(values)[:, None]


def _check(raised: Raised, u: Array, v: Array, source: str) -> None:
    outcome, factor = raised.outcome[0], raised.factor[0]
    if outcome == REACHED:
        return
    if outcome == LIMITED:
        steepest = int(np.maximum(np.abs(u), np.abs(v)).argmax())
        problem = f"segment {steepest} is bent by 90 degrees"
    else:
        problem = "the joint buckles"
    raise ReachError(
        f"{source}: at {factor:.3g} of these loads {problem}; lower them or raise stiffness"
    )
