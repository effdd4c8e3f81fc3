"""What a joint is: its specification, and the file that states it."""

from ccgen.joint.specification import (
    AXES,
    CASES,
    METHODS,
    AxisSensors,
    Can,
    Geometry,
    Joint,
    RecordingFile,
    Sensor,
    ShapeSettings,
    Transducer,
)

__all__ = [
    "AXES",
    "CASES",
    "METHODS",
    "AxisSensors",
    "Can",
    "Geometry",
    "Joint",
    "RecordingFile",
    "Sensor",
    "ShapeSettings",
    "Transducer",
]
