"""Loads on a joint: one stated set of them, and the ranges that a joint meets at work.

Angles are in radians, lengths in metres, forces in newtons; the base frame has z along the unbent
axis. Places along the joint are measured without elongation.
"""

from dataclasses import dataclass, field

Range = tuple[float, float]
"""Lowest and highest value; a constant where they are equal."""

Vector = tuple[float, float, float]

ZERO: Range = (0.0, 0.0)

PARTS = 4
"""Equal parts in which stiffness varies where no profile is stated."""


@dataclass(frozen=True)
class Contact:
    """A force at one point of the joint."""

    at: float
    """Along the neutral axis from the base, metres."""
    force: Vector
    """Newtons, base frame."""


@dataclass(frozen=True)
class StatedLoads:
    """Loads under which a joint has one shape."""

    stiffness: float
    """Bending stiffness where the profile is 1, N m^2."""
    stiffness_profile: tuple[float, ...] = (1.0,)
    """Stiffness of equal parts from the base, relative to `stiffness`."""
    actuation: tuple[float, float] = (0.0, 0.0)
    """Bends u and v of the whole joint by the actuators alone, radians."""
    tip_force: Vector = (0.0, 0.0, 0.0)
    """Newtons."""
    tip_moment: tuple[float, float] = (0.0, 0.0)
    """About x and y of the tip, newton metres."""
    distributed: Vector = (0.0, 0.0, 0.0)
    """Newtons per metre of the joint without elongation."""
    contacts: tuple[Contact, ...] = ()
    elongation: tuple[float, ...] = ()
    """Share of the length of each section; empty: none."""
    source: str = field(default="", compare=False)
    """The file as the user named it: for messages only."""


@dataclass(frozen=True)
class LoadRanges:
    """[loads]: ranges from which loads are drawn."""

    samples: int
    stiffness: float
    """Bending stiffness where the profile is 1, N m^2."""
    stiffness_profile: tuple[float, ...] = (1.0,)
    """Stiffness of equal parts from the base, relative to `stiffness`."""
    stiffness_tolerance: float = 0.0
    """Standard deviation of the logarithm of each part's stiffness."""
    actuation: Range = ZERO
    """Bend of the whole joint by the actuators alone, each axis, radians."""
    mass: float = 0.0
    """Spread along the joint, kg."""
    mounting: float | None = None
    """Angle between gravity and the unbent axis, radians; None: any direction."""
    payload: Range = ZERO
    """At the tip, kg."""
    tip_force: Range = ZERO
    """Across the unbent axis, newtons."""
    tip_moment: Range = ZERO
    """Newton metres."""
    contact: Range = ZERO
    """A force of any direction, newtons."""
    contact_from: float = 0.0
    """Nearest place of the contact, along the neutral axis from the base, metres."""
    elongation: Range = ZERO
    """Share of the length, of each section."""
