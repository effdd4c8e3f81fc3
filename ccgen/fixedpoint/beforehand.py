"""What the counts of a joint do not hold, known before its recordings are learned from.

Learning takes its time and changes nothing about sensors whose counts are too few for the range of
motion, or whose zero lies too near to their end. Gains are the exception: where recordings may tell
them, what the joint file states leaves a doubt and no more.
"""

from ccgen.errors import FormatError
from ccgen.estimation.sources import CASES, LOADS, source_weights
from ccgen.fixedpoint.formats import sensor_ranges
from ccgen.fixedpoint.ranges import at_range
from ccgen.fixedpoint.relative import relative_ranges
from ccgen.joint import Joint


def check_counts(joint: Joint) -> tuple[str, ...]:
    """Check that counts hold the range of motion of a joint that names recordings.

    Args:
        joint: as its file has it.

    Returns:
        What is doubtful as long as recordings have not told gains, a sentence each.

    Raises:
        FormatError: they do not, whatever the recordings tell; names the sensor, the key and the
            remedy.
    """
    if not joint.recordings or not _holds_range(joint):
        return ()
    try:
        _check_ranges(joint)
    except FormatError as error:
        if _learns(joint) and joint.calibration is None:
            return (f"{error}; no fixed point can be exported unless recordings tell other gains",)
        raise
    return ()


def _check_ranges(joint: Joint) -> None:
    shapes = at_range(joint)
    for axis in joint.axes:
        try:
            sensor_ranges(joint, axis, shapes)
        except FormatError:
            if not _learns(joint):
                raise
            relative_ranges(joint, axis, shapes)  # that of sensors whose zero recordings told


def _learns(joint: Joint) -> bool:
    """Whether recordings may tell of the sensors."""
    return any(one.use == "fit" for one in joint.recordings)


def _holds_range(joint: Joint) -> bool:
    """Whether formats hold the whole range of motion, whatever the recordings tell.

    Of the paper's sets fitted to load cases alone they hold those, which may be less.
    """
    if joint.couples:
        return True
    bodies = any(one.use == "fit" and one.stations for one in joint.recordings)
    # Recordings of the straight joint alone are no shapes to fit to.
    shaped = (True,) if bodies else (True, False) if _learns(joint) else (False,)
    return all(_reaches(joint, recorded) for recorded in shaped)


def _reaches(joint: Joint, recorded: bool) -> bool:
    weights = source_weights(joint, recorded)
    if (recorded and weights["recordings"] > 0) or (joint.loads is not None and weights[LOADS] > 0):
        return True
    return "constant-curvature" in joint.shapes.cases and weights[CASES] > 0
