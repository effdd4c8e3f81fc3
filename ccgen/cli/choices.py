"""Options of several commands, and words that they choose from, as in the joint file."""

from enum import StrEnum
from typing import Annotated

import typer

Individuals = Annotated[
    int, typer.Option("--individuals", help="Population of the evolutionary algorithm.")
]
Generations = Annotated[
    int, typer.Option("--generations", help="Generations of the evolutionary algorithm.")
]


class Level(StrEnum):
    """Levels of the compiler's optimisation, `ccgen.targets.compiler.LEVELS`."""

    O0 = "0"
    OS = "s"
    O2 = "2"
    O3 = "3"


Optimise = Annotated[
    Level,
    typer.Option("--optimise", help="The level at which the folder is compiled, as behind -O."),
]


class Axis(StrEnum):
    """The bending axes, `ccgen.joint.AXES`."""

    U = "u"
    V = "v"


class Case(StrEnum):
    """The load cases, `ccgen.joint.CASES`."""

    END_FORCE = "end-force"
    UNIFORM = "uniform"
    S_SHAPE = "s-shape"
    CONSTANT_CURVATURE = "constant-curvature"


class Method(StrEnum):
    """The estimation methods, `ccgen.estimation.FIT_METHODS`."""

    DIRECT = "direct"
    EQUAL = "equal"
    WAM = "wam"
    NOISE_AWARE = "noise-aware"
    WAM_PAPER_CALL = "wam-paper-call"


class Speed(StrEnum):
    """How fast a file is read or sent: at its own times, or as fast as it goes."""

    LIKE = "1"
    MAX = "max"
