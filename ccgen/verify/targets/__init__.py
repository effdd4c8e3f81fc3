"""Microcontrollers in emulators."""

from ccgen.verify.targets.cross import CORES, missing_tools
from ccgen.verify.targets.verify import emulated_node, verify_target

TARGETS = tuple(CORES)
"""Names of all emulated targets."""

__all__ = ["TARGETS", "emulated_node", "missing_tools", "verify_target"]
