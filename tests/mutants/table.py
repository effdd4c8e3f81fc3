"""All mutants."""

from mutants import frames, kernels, node, ports

GROUPS = (*frames.GROUPS, *node.GROUPS, *kernels.GROUPS, *ports.GROUPS)
