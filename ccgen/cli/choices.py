"""Words that options choose from; the same as in the joint file and the library."""

from enum import StrEnum


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
