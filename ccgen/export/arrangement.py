"""The drawing of the sensors in an exported folder: where each mark of the SVG stands."""

from typing import Any

import numpy as np

from ccgen.joint import Joint
from ccgen.sensing.arrangement import angle_degrees, unrolled
from ccgen.sensing.readings import direction

_CENTRE, _RADIUS = (120.0, 132.0), 78.0
_LEFT, _RIGHT, _TOP, _ROW = 360.0, 700.0, 48.0, 17.0
_BELOW = 46.0


def arrangement_context(joint: Joint) -> dict[str, Any]:
    """Values that the template sensors.svg.j2 knows as `drawing`, in pixels."""
    segments, rows = joint.geometry.segments, unrolled(joint)
    bottom = _TOP + _ROW * len(rows)

    def along(border: float) -> str:
        return _pixels(_LEFT + (_RIGHT - _LEFT) * border / segments)

    return {
        "centre": [_pixels(x) for x in _CENTRE],
        "radius": _pixels(_RADIUS),
        "height": _pixels(max(bottom + _BELOW, 2 * _CENTRE[1])),
        "left": _pixels(_LEFT),
        "right": _pixels(_RIGHT),
        "top": _pixels(_TOP),
        "bottom": _pixels(bottom),
        "points": _points(joint),
        "rows": [
            {
                "name": sensor.name,
                "angle": f"{angle_degrees(sensor):.4g}",
                "start": along(sensor.start),
                "end": along(sensor.end),
                "y": _pixels(_TOP + _ROW * (k + 0.5)),
            }
            for k, sensor in enumerate(rows)
        ],
        "ticks": [
            {"segment": k, "x": along(k)} for k in range(0, segments + 1, max(1, segments // 12))
        ],
        "sections": [along(border) for border in np.cumsum(joint.geometry.sections)[:-1].tolist()],
    }


def _points(joint: Joint) -> list[dict[str, str]]:
    """A mark for each angle and radius at which sensors run, and its label farther out."""
    largest = max(sensor.radius for sensor in joint.sensors)
    places = {(angle_degrees(s), s.radius): direction(s) for s in joint.sensors}
    points = []
    for (angle, radius), (sine, cosine) in sorted(places.items()):
        out = _RADIUS * radius / largest
        points.append(
            {
                "x": _pixels(_CENTRE[0] + out * cosine),
                "y": _pixels(_CENTRE[1] - out * sine),
                "label_x": _pixels(_CENTRE[0] + (out + 20.0) * cosine),
                "label_y": _pixels(_CENTRE[1] - (out + 20.0) * sine + 4.0),
                "angle": f"{angle:.4g}",
            }
        )
    return points


def _pixels(value: float) -> str:
    return f"{value:.1f}"
