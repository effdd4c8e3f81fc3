"""Where to put the sensors: the paper's evolutionary algorithm, and a search that does better."""

from ccgen.placement.asked import OBJECTIVES
from ccgen.placement.constraints import Constraints
from ccgen.placement.evolution import Evolution, evolve
from ccgen.placement.faults import wide_shapes
from ccgen.placement.listed import ListedProblem
from ccgen.placement.methods import METHODS, STATED, place_by
from ccgen.placement.placed import Placed, place
from ccgen.placement.problem import Placement, Problem, check_placeable, joint_problem, placed_noise
from ccgen.placement.search import Search, search
from ccgen.placement.sets import SetsProblem
from ccgen.placement.told import Told, told

__all__ = [
    "METHODS",
    "OBJECTIVES",
    "STATED",
    "Constraints",
    "Evolution",
    "ListedProblem",
    "Placed",
    "Placement",
    "Problem",
    "Search",
    "SetsProblem",
    "Told",
    "check_placeable",
    "evolve",
    "joint_problem",
    "place",
    "place_by",
    "placed_noise",
    "search",
    "told",
    "wide_shapes",
]
