"""What joints share on a bus: identifiers, data IDs, the bit rate, the time that frames take."""

from collections.abc import Iterator, Sequence
from itertools import combinations

from ccgen.can.layout import LARGEST_ID
from ccgen.check.member import Resident
from ccgen.check.problem import Problem

LARGEST_LOAD = 0.7
"""Share of the time above which a bus counts as full: what is sent besides must fit, too."""

_NEAT = 16
"""Identifiers that are proposed are multiples of this where there is room."""


def bus_load(joints: Sequence[Resident]) -> float:
    """Share of the time that the frames of all joints take at most, each at its own bit rate."""
    return sum(joint.load for joint in joints)


def bus_problems(joints: Sequence[Resident]) -> Iterator[Problem]:
    """What two joints cannot both have, and what they cannot have together."""
    for first, second in combinations(joints, 2):
        yield from _shared(first, second, joints)
    yield from _bit_rates(joints)
    load = bus_load(joints)
    if load > LARGEST_LOAD:
        yield _too_much(load, joints)


def _shared(first: Resident, second: Resident, joints: Sequence[Resident]) -> Iterator[Problem]:
    """Identifiers of two joints that overlap or, if none do, data IDs that coincide."""
    pair = f"{second.name} has {_told(second)}, {first.name} ({first.path}) {_told(first)}"
    own, others = second.identifiers, first.identifiers
    overlap = range(max(own.start, others.start), min(own.stop, others.stop))
    if overlap and first.layout.extended == second.layout.extended:
        yield Problem(
            second.path,
            "identifiers",
            f"can.base_id: {pair}; {_remedy(second, joints)}",
        )
        return
    common = first.data_ids & second.data_ids
    if common:
        yield Problem(
            second.path,
            "data-ids",
            f"can.base_id: {pair}: frames of both have the data ID {min(common):#06x}, the low 16 "
            f"bits of their identifiers; {_remedy(second, joints)}",
        )


def _told(joint: Resident) -> str:
    kind = "extended identifiers" if joint.layout.extended else "identifiers"
    return f"{kind} {joint.layout.base_id:#x} to {joint.layout.last_id:#x}"


def _remedy(joint: Resident, joints: Sequence[Resident]) -> str:
    others = [other for other in joints if other is not joint]
    taken = frozenset[int]().union(*(other.data_ids for other in others))
    frames = len(joint.identifiers)
    largest = LARGEST_ID[joint.layout.extended]
    behind = sorted(other.layout.last_id + 1 for other in others)
    neat = sorted(-(-end // _NEAT) * _NEAT for end in behind)
    for base in (*neat, *behind):
        wanted = range(base, base + frames)
        if wanted[-1] <= largest and not any(wanted_id & 0xFFFF in taken for wanted_id in wanted):
            return f"write base_id = {base:#x}"
    return "move one of them to where nobody is"


def _bit_rates(joints: Sequence[Resident]) -> Iterator[Problem]:
    for joint in joints[1:]:
        first, rate = joints[0], joint.joint.can.bitrate
        if rate != first.joint.can.bitrate:
            yield Problem(
                joint.path,
                "bit-rate",
                f"can.bitrate: {joint.name} states {rate:,} bit/s, {first.name} ({first.path}) "
                f"{first.joint.can.bitrate:,}; a bus has one",
            )


def _too_much(load: float, joints: Sequence[Resident]) -> Problem:
    most = max(joints, key=lambda joint: joint.load)
    shares = ", ".join(f"{joint.name} {100.0 * joint.load:.0f} %" for joint in joints)
    return Problem(
        most.path,
        "bus-load",
        f"can.cycle_ms: {shares}: {100.0 * load:.0f} % of the time in all, above "
        f"{100.0 * LARGEST_LOAD:.0f} % a bus counts as full; write a longer cycle_ms or fewer "
        "frames in publish",
    )
