"""A user's own functions of a joint's angles, in integers."""

from ccgen.functions.compiling import compile_functions
from ccgen.functions.integer import JointFunctions
from ccgen.functions.module import Module, read_module

__all__ = ["JointFunctions", "Module", "compile_functions", "read_module"]
