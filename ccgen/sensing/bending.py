"""What bends a joint once, and any share of it: a way from the straight joint to a shape."""

from dataclasses import dataclass, replace

from ccgen.joint import Joint
from ccgen.joint.loads import StatedLoads, Vector
from ccgen.sensing.simulation import Simulation, simulate


@dataclass(frozen=True)
class Bending:
    """A load case with the angle of its first segment, or stated loads; as of `simulate`."""

    case: str | None = None
    first_segment: float | None = None
    axis: str | None = None
    loads: StatedLoads | None = None

    def at(self, joint: Joint, share: float = 1.0) -> Simulation:
        """Bend a joint by a share of it, 0 to 1.

        Raises:
            As `simulate`.
        """
        if self.loads is not None:
            return simulate(joint, self.case, self.first_segment, self.axis,
                            scaled(self.loads, share))  # fmt: skip
        first = None if self.first_segment is None else share * self.first_segment
        return simulate(joint, self.case, first, self.axis, far=True)


def scaled(loads: StatedLoads, share: float) -> StatedLoads:
    """A share of all loads, and of the elongation."""
    if share == 1.0:
        return loads
    return replace(
        loads,
        actuation=(share * loads.actuation[0], share * loads.actuation[1]),
        tip_force=_scaled(loads.tip_force, share),
        tip_moment=(share * loads.tip_moment[0], share * loads.tip_moment[1]),
        distributed=_scaled(loads.distributed, share),
        contacts=tuple(replace(one, force=_scaled(one.force, share)) for one in loads.contacts),
        elongation=tuple(share * part for part in loads.elongation),
    )


def _scaled(vector: Vector, share: float) -> Vector:
    x, y, z = vector
    return share * x, share * y, share * z
