"""All mutants."""

from mutants import frames, kernels, node

GROUPS = (*frames.GROUPS, *node.GROUPS, *kernels.GROUPS)
