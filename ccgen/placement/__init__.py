"""Where to put the sensors: the paper's evolutionary algorithm, and a search that does better."""

from ccgen.placement.constraints import Constraints
from ccgen.placement.evolution import Evolution, evolve
from ccgen.placement.faults import visible_faults, wide_shapes
from ccgen.placement.methods import METHODS, place_by
from ccgen.placement.placed import OBJECTIVES, Placed, place
from ccgen.placement.problem import Placement, Problem, check_placeable, joint_problem, placed_noise
from ccgen.placement.search import Search, search
from ccgen.placement.stated import StatedProblem
from ccgen.placement.told import error_rows, scores

__all__ = [
    "METHODS",
    "OBJECTIVES",
    "Constraints",
    "Evolution",
    "Placed",
    "Placement",
    "Problem",
    "Search",
    "StatedProblem",
    "check_placeable",
    "error_rows",
    "evolve",
    "joint_problem",
    "place",
    "place_by",
    "placed_noise",
    "scores",
    "search",
    "visible_faults",
    "wide_shapes",
]
