"""A sight as lines and frames: plain arrays, whatever shows them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.figures.curves import POINTS_PER_SEGMENT, frames_along, string_paths
from ccgen.joint import Joint
from ccgen.sensing.simulation import segment_lengths
from ccgen.view.sight import Bends, Floats, Sight

Colours = NDArray[np.uint8]

SHORT, NEUTRAL, LONG = (0, 114, 178), (214, 214, 214), (230, 120, 0)
"""Colours of strings at the end of their range, unbent, and at the other end."""
MISSING, SUSPECTED = (90, 90, 90), (204, 60, 150)

_DASH = 3
"""Pieces of a string that are drawn, then as many that are not, where a reading is missing."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """What is drawn of a sight, metres in the base frame.

    Attributes:
        backbone: pieces of the neutral axis, shape (k, 2, 3).
        places, turns: origins, shape (m + 1, 3), and quaternions w, x, y, z, shape (m + 1, 4), of
            the base and of the frame at the end of every segment.
        strings: pieces of all sensors, shape (p, 2, 3).
        string_colours: shape (p, 2, 3).
        tip: shape (3,).
        ghost: pieces of the true neutral axis, shape (k, 2, 3); none where it is not known.
    """

    backbone: Floats
    places: Floats
    turns: Floats
    strings: Floats
    string_colours: Colours
    tip: Floats
    ghost: Floats


def drawing_of(joint: Joint, sight: Sight) -> Drawing:
    """Draw a sight."""
    from scipy.spatial.transform import Rotation

    frames = _frames(joint, sight.estimate)
    ends = frames[::POINTS_PER_SEGMENT]
    turns = np.roll(Rotation.from_matrix(ends[:, :3, :3]).as_quat(), 1, axis=1)
    strings, colours = _strings(joint, sight, frames)
    ghost = np.empty((0, 2, 3))
    if sight.truth is not None:
        ghost = pieces(_frames(joint, sight.truth)[:, :3, 3])
    return Drawing(
        backbone=pieces(frames[:, :3, 3]),
        places=ends[:, :3, 3],
        turns=turns,
        strings=strings,
        string_colours=colours,
        tip=frames[-1, :3, 3],
        ghost=ghost,
    )


def pieces(points: Floats) -> Floats:
    """The pieces of a line through points, shape (k, 2, 3) from (k + 1, 3)."""
    return np.stack([points[:-1], points[1:]], axis=1)


def colour(share: float) -> tuple[int, ...]:
    """Colour of a reading, from -1 to 1 of the range of motion and beyond."""
    end = LONG if share > 0 else SHORT
    part = min(abs(share), 1.0)
    return tuple(round((1 - part) * a + part * b) for a, b in zip(NEUTRAL, end, strict=True))


def _frames(joint: Joint, bends: Bends) -> Floats:
    return frames_along(bends.u, bends.v, segment_lengths(joint, bends.h))


def _strings(joint: Joint, sight: Sight, frames: Floats) -> tuple[Floats, Colours]:
    lines, colours = [], []
    paths = string_paths(joint, frames)
    for sensor, path, reading in zip(joint.sensors, paths, sight.readings, strict=True):
        line = pieces(path)
        drawn: tuple[int, ...] = NEUTRAL
        if sensor.name in sight.missing:
            line, drawn = _broken(line), MISSING
        elif sensor.name in sight.suspected:
            drawn = SUSPECTED
        elif not np.isnan(reading):
            drawn = colour(float(reading) / joint.geometry.range_of_motion)
        lines.append(line)
        colours.append(np.broadcast_to(np.array(drawn, dtype=np.uint8), line.shape))
    return np.concatenate(lines), np.concatenate(colours)


def _broken(line: Floats) -> Floats:
    """Dashes of a line, as many pieces as before: those of gaps lie on the dash before them."""
    place = np.arange(len(line))
    dash, within = place // (2 * _DASH) * 2 * _DASH, place % (2 * _DASH)
    return line[dash + np.minimum(within, _DASH - 1)]
