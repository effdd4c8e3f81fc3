"""Whether what weights are fitted to tells them: by movement in every direction, often enough.

Other loads show what a joint may do. A direction in which they bend it and no source does is left
to chance, however small the error on those sources.
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.sources import Source
from ccgen.estimation.weights import Floats

if TYPE_CHECKING:
    from ccgen.joint import Joint

_HARDLY = 0.1
"""Share of what other loads do, or of the elongation's range, below which a source does nothing."""
_ROWS_A_SENSOR = 2.0
"""Independent rows for each sensor of an axis from which on they tell its weights."""

_DIRECTIONS = (
    "as a whole",
    "with its tip against its base",
    "with its middle against its ends",
)
"""Bends along a joint, the coarsest first: cosines of 0, half and one turn."""


def unexcited(joint: "Joint", sources: Sequence[Source], others: Source) -> Iterator[str]:
    """Say in which directions none of the sources that weights are fitted to moves the joint.

    Args:
        joint: its axes and sensors.
        sources: with a weight above 0.
        others: shapes of other loads.
    """
    names = " and ".join(source.name for source in sources)
    for axis in joint.axes:
        if axis == "h":
            yield from _unstretched(joint, sources, names)
            continue
        own = joint.own(axis)
        told = min(len(_DIRECTIONS), own.stop - own.start, joint.geometry.segments)
        modes = _modes(joint.geometry.segments)[:told]
        rows = joint.rows(axis)
        most = np.max([_sizes(source, modes, rows) for source in sources], axis=0)
        for direction, size, usual in zip(
            _DIRECTIONS, most, _sizes(others, modes, rows), strict=False
        ):
            if size < _HARDLY * usual:
                yield (
                    f"axis {axis}: {names} hardly bend the joint {direction} "
                    f"({np.degrees(size):.2g} degrees a segment, other loads "
                    f"{np.degrees(usual):.2g}), so that weights are left to chance there; record "
                    "or state movements that do"
                )


def _unstretched(joint: "Joint", sources: Sequence[Source], names: str) -> Iterator[str]:
    size = max(_rms(source.shapes.h) for source in sources)
    largest = max(map(abs, joint.geometry.elongation or (0.0,)))
    if size < _HARDLY * largest:
        yield (
            f"axis h: {names} hardly elongate the joint ({100 * size:.2g} % of its length, its "
            f"range reaches {100 * largest:.2g} %), so that weights are left to chance there; "
            "record or state movements that do"
        )


def few_rows(joint: "Joint", sources: Sequence[Source]) -> Iterator[str]:
    """Say which recordings hold too few independent rows for the weights that they tell.

    Args:
        joint: its axes and sensors.
        sources: recordings that weights are fitted to, rows in order of time.
    """
    for source in sources:
        from ccgen.recordings.learning import independent_rows

        for axis in joint.axes:
            own = joint.own(axis)
            wanted = _ROWS_A_SENSOR * (own.stop - own.start)
            count = independent_rows(source.shapes.state[:, joint.rows(axis)])
            if count < wanted:
                yield (
                    f"axis {axis}: the {len(source)} rows of {source.name} count as "
                    f"{max(1, round(count))} that are independent, too few to tell the weights of "
                    f"{own.stop - own.start} sensors; record longer, with more different movements"
                )


def _modes(segments: int) -> Floats:
    """Orthonormal bends along a joint, shape (3, m); at most m are different."""
    along = (np.arange(segments) + 0.5) / segments
    waves = np.cos(np.pi * np.outer(np.arange(len(_DIRECTIONS)), along))
    lengths: Floats = np.linalg.norm(waves, axis=1, keepdims=True)
    return np.asarray(waves / np.maximum(lengths, 1e-9))


def _sizes(source: Source, modes: Floats, rows: slice) -> Floats:
    """Root mean square of a segment in each direction, radians."""
    along = source.shapes.state[:, rows] @ modes.T
    return np.asarray(np.sqrt(np.mean(np.square(along), axis=0) / modes.shape[1]))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
