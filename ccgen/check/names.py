"""Names of joints that would meet in one program.

Names that a joint may have meet no other joint's, unless they are the same to a file system or a
preprocessor that knows no capitals (`ccgen.joint.names`); sensors' names are the user's own.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations

from ccgen.check.member import Resident
from ccgen.check.problem import Problem


def name_problems(joints: Sequence[Resident]) -> Iterator[Problem]:
    """Pairs of joints that no program can hold both."""
    for first, second in combinations(joints, 2):
        if first.name.lower() == second.name.lower():
            differ = "" if first.name == second.name else " but for capitals"
            yield Problem(
                second.path,
                "names",
                f"name: {second.name} and {first.name} ({first.path}) are one name{differ}; "
                "their files and macros would meet in one program; rename one of them",
            )
        for joint, other in ((first, second), (second, first)):
            for constant in _constants(joint):
                if constant.startswith(f"{other.name.upper()}_") and joint.name != other.name:
                    yield Problem(
                        joint.path,
                        "names",
                        f"the constant {constant} of {joint.name} is named like those of "
                        f"{other.name} ({other.path}); rename the sensor or one of the joints",
                    )


def _constants(joint: Resident) -> list[str]:
    """Constants that carry names of sensors; the paper's sets have none."""
    if joint.layout.own_sets:
        return []
    prefix = f"{joint.name.upper()}_SENSOR_"
    return [f"{prefix}{name.upper()}" for name in joint.layout.sensors]
