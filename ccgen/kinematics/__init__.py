"""The joint's kinematics (uvh): poses, Jacobian, tendon lengths, and how exact they are in C."""

from ccgen.kinematics.tip import tip_position, tip_slopes
from ccgen.kinematics.uvh import (
    U_SENSOR_ANGLE,
    V_SENSOR_ANGLE,
    chain,
    elongation_columns,
    segment_transform,
    tendon_length,
    tip_jacobian,
    tip_pose,
)

__all__ = [
    "U_SENSOR_ANGLE",
    "V_SENSOR_ANGLE",
    "chain",
    "elongation_columns",
    "segment_transform",
    "tendon_length",
    "tip_jacobian",
    "tip_pose",
    "tip_position",
    "tip_slopes",
]
