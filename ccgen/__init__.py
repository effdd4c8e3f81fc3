"""ccgen: shape estimation of continuum joints, from a joint's description to proven C."""

__version__ = "0.1.0"

FORMAT_VERSION = 1
"""Version of what generator and C runtime agree on; `CCGEN_FORMAT_VERSION` in C."""
