"""Reading `joint.toml`: every error is one line with file, key, what is wrong, what is right."""

from ccgen.joint_file.build import parse, read

__all__ = ["parse", "read"]
