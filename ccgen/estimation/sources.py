"""Where the shapes come from that weights are fitted to, and how much each source counts.

A source counts as a whole: its weight is shared evenly by its rows, so that a long recording does
not outvote drawn loads by its length. Sources of weight 0 are not fitted to; errors are told on
them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ccgen.errors import InputError
from ccgen.estimation.weights import Floats
from ccgen.sensing.readings import length_changes, normaliser
from ccgen.shapes import Shapes, fit_shapes, within_axes

if TYPE_CHECKING:
    from ccgen.joint import Joint

CASES, LOADS, OTHER, RECORDING = "cases", "loads", "other loads", "recording:"
"""Names of sources; those of recordings begin so."""

_STILL = 1e-8
"""Radians, or share of the length, that a shape in which an axis moves has somewhere."""

RECORDED_WEIGHTS = {"cases": 0.0, "loads": 0.05, "recordings": 1.0}
"""Of the sources where recordings are given."""


_ENOUGH = 1500
"""Rows of a source by which weights are compared."""


@dataclass(frozen=True, eq=False)
class Source:
    """Shapes of one origin, with what the sensors read of them.

    Attributes:
        name: as `errors` calls it, such as "cases" or "recording:run1.csv".
        shapes: N rows.
        weight: of the source as a whole.
        readings: normalised readings that belong to the rows, shape (N, n), NaN where a sensor
            had none; None for those of ideal sensors.
        moment: second moment of the states, shape (2m + S, 2m + S), where the rows alone do not
            tell it, being the most probable shapes of a recording.
        notes: what is to be said of the source, a sentence each.
    """

    name: str
    shapes: Shapes
    weight: float
    readings: Floats | None = None
    moment: Floats | None = None
    notes: tuple[str, ...] = field(default=())

    def __len__(self) -> int:
        return len(self.shapes)

    @property
    def thinned(self) -> "Source":
        """Evenly chosen rows, enough to compare weights by."""
        return self.at_most(_ENOUGH)

    def at_most(self, rows: int) -> "Source":
        """Evenly chosen rows, no more than so many."""
        every = slice(None, None, -(-len(self) // rows))
        u, v, h = (part[every] for part in (self.shapes.u, self.shapes.v, self.shapes.h))
        readings = None if self.readings is None else self.readings[every]
        return replace(self, shapes=Shapes(u, v, h, self.shapes.source[every]), readings=readings)

    @property
    def spread(self) -> "Source":
        """Shapes of the same second moment, with readings without noise."""
        shapes = self.shapes if self.moment is None else _rows_of(self.moment, self.shapes)
        return replace(self, shapes=shapes, readings=None, moment=None)


def _rows_of(moment: Floats, like: Shapes) -> Shapes:
    """As many rows as states have numbers, whose mean of x x^T is this second moment."""
    size, direction = np.linalg.eigh(moment)
    states = (direction * np.sqrt(np.maximum(size, 0.0) * len(size))).T
    m = like.segments
    parts = states[:, :m], states[:, m : 2 * m], states[:, 2 * m :]
    return Shapes(*parts, like.source[:1] * len(states))


def ideal_readings(joint: "Joint", shapes: Shapes) -> Floats:
    """Normalised readings of sensors without error, shape (N, n)."""
    return np.asarray(length_changes(joint, shapes.state) / normaliser(joint))


def read(joint: "Joint", source: Source) -> Floats:
    """Normalised readings of a source's rows, shape (N, n)."""
    return ideal_readings(joint, source.shapes) if source.readings is None else source.readings


def simulated_sources(joint: "Joint", recorded: bool = False) -> list[Source]:
    """The four cases, where they count, and the joint's loads, as the joint file weighs them.

    Args:
        joint: what states them.
        recorded: whether recordings to fit to are given beside them.

    Raises:
        ReachError: the cases or the loads do not bend the joint so far.
    """
    weights = source_weights(joint, recorded)
    sources = []
    if joint.shapes.cases and weights[CASES] > 0:
        sources.append(Source(CASES, fit_shapes(joint), weights[CASES]))
    if joint.loads is not None:
        from ccgen.shapes.loads.library import loads_library, shortfall

        drawn = loads_library(joint)
        if drawn is not None:
            lack = shortfall(drawn, joint.loads.samples)
            shapes = within_axes(joint, drawn.shapes)
            sources.append(Source(LOADS, shapes, weights[LOADS], notes=(lack,) if lack else ()))
    return sources


def source_weights(joint: "Joint", recorded: bool) -> Mapping[str, float]:
    """Weight of "cases", "loads" and "recordings" as stated, or by what there is."""
    if recorded:
        usual = RECORDED_WEIGHTS
    elif joint.loads is not None:
        usual = {"cases": 0.0, "loads": 1.0, "recordings": 0.0}
    else:
        usual = {"cases": 1.0, "loads": 0.0, "recordings": 0.0}
    return {**usual, **dict(joint.shapes.weight)}


def still_axes(joint: "Joint", sources: Sequence[Source]) -> list[str]:
    """Output axes that no shape to fit to moves by more than rounding: weights there are zero."""
    counted = [source.shapes.state for source in sources if source.weight > 0]
    if not counted:
        return []
    largest = np.abs(np.concatenate(counted)).max(axis=0, initial=0.0)
    return [axis for axis in joint.axes if np.all(largest[joint.rows(axis)] < _STILL)]


@dataclass(frozen=True, eq=False)
class Rows:
    """What weights are fitted to, row by row.

    Attributes:
        state: shape (N, 2m + S).
        readings: normalised, shape (N, n); NaN where a sensor had none.
        weight: of each row, shape (N,); their sum is 1.
    """

    state: Floats
    readings: Floats
    weight: Floats

    @property
    def second_moment(self) -> Floats:
        """Weighted mean of x x^T, shape (2m + S, 2m + S)."""
        moment: Floats = (self.state * self.weight[:, None]).T @ self.state
        return moment


def weighed_rows(joint: "Joint", sources: Sequence[Source]) -> Rows:
    """All rows of the sources that count.

    Raises:
        InputError: no source that counts.
    """
    counted = [source for source in sources if source.weight > 0 and len(source)]
    if not counted:
        raise InputError(
            f"{joint.source}: shapes.weight: leaves no shapes to fit to; give cases or [loads] a "
            "weight above 0"
        )
    total = sum(source.weight for source in counted)
    return Rows(
        np.concatenate([source.shapes.state for source in counted]),
        np.concatenate([read(joint, source) for source in counted]),
        np.concatenate(
            [np.full(len(source), source.weight / total / len(source)) for source in counted]
        ),
    )
