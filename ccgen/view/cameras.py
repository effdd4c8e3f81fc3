"""From where a page sees the joint: from beside and above, with all of it clear of the panel."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from viser import CameraHandle, InitialCameraConfig

Point = tuple[float, float, float]

FIELD_OF_VIEW = 0.8
"""Height of what a camera sees, radians."""

_NARROW = 600
"""Pixels of a page's width below which the panel lies at its bottom instead of at its side."""

_BESIDE: Point = (1.2, -1.7, 0.68)
"""From the middle of what is seen to the camera, in lengths of the joint."""

_MIDDLE = 0.42
"""Height of what is in the middle of a page, in lengths of the joint."""

_AWAY, _BELOW = 2.4, 1.2
"""On a narrow page: how many times as far, and how much lower, in lengths of the joint.

The panel covers the lower six tenths of such a page; above it the joint is as large as it can be.
"""


def aim(camera: "CameraHandle | InitialCameraConfig", length: float, narrow: bool = False) -> None:
    """Point a camera at a joint that stands on the origin.

    Args:
        camera: that of a page.
        length: of the joint, m.
        narrow: whether the panel lies at the bottom of the page.
    """
    away, middle = (_AWAY, _MIDDLE - _BELOW) if narrow else (1.0, _MIDDLE)
    x, y, z = (length * away * part for part in _BESIDE)
    camera.position = (x, y, z + length * middle)
    camera.look_at = (0.0, 0.0, length * middle)


def is_narrow(width: int) -> bool:
    """Whether the panel of a page of so many pixels lies at its bottom."""
    return width < _NARROW
