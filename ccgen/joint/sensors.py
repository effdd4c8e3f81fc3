"""The paper's sets of sensors: what [sensors] says for both axes, with an axis' keys in place."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ccgen.joint.layouts import AnySpans, spans_for
from ccgen.joint.messages import KeyProblemError, missing_key
from ccgen.joint.sensor_tables import AxisTable, SensorsTable
from ccgen.joint.spans import metres_span, segments_said, segments_span, uncovered
from ccgen.joint.specification import AxisSensors, Geometry, Sensor, Transducer
from ccgen.joint.transducers import Stated, transducer

_DEFAULT_COUNT = 3
_DEFAULT_PLACEMENT = "heuristic"

_ANGLES_DEG = {"u": 90.0, "v": 180.0}
"""Where the paper's two sets run: u's at +y, v's at -x."""


@dataclass(frozen=True)
class _Overlay:
    """Looks up a key in the table of the axis first, then in that for both axes."""

    own: AxisTable
    common: AxisTable
    axis: str

    def get(self, key: str) -> Any:
        value = getattr(self.own, key)
        return getattr(self.common, key) if value is None else value

    def place(self, key: str) -> str:
        """Return the full name of the key that `get` answers from."""
        own = getattr(self.own, key) is not None
        return f"sensors.{self.axis}.{key}" if own else f"sensors.{key}"


@dataclass(frozen=True)
class _Set:
    """The sensors of one axis: their spans, and where they stand among all `total`."""

    overlay: _Overlay
    placement: str
    spans: AnySpans
    first: int
    total: int

    def stated(self, key: str, j: int) -> Stated:
        """What the file says of the transducer of sensor j of the set."""
        own, common = self.overlay.own.transducer, self.overlay.common.transducer
        if getattr(own, key) is not None:
            place = f"sensors.{self.overlay.axis}.transducer.{key}"
            return self._one(getattr(own, key), place, j)
        return self._one(getattr(common, key), f"sensors.transducer.{key}", j, shared=True)

    def radius(self, j: int) -> float:
        """Distance of sensor j of the set from the neutral axis, metres."""
        shared = self.overlay.own.radius is None
        value = self._one(self.overlay.get("radius"), self.overlay.place("radius"), j, shared).value
        if value is None:
            raise KeyProblemError(missing_key("sensors.radius", AxisTable.model_fields["radius"]))
        return float(value)

    def _one(self, value: Any, place: str, j: int, shared: bool = False) -> Stated:
        """Value of sensor j; a shared list has one for each sensor of an axis, or of both."""
        if not is_each(value, place):
            return Stated(value, place)
        if shared and len(value) == self.total:
            return Stated(value[self.first + j], f"{place}[{self.first + j}]")
        if len(value) != len(self.spans):
            raise KeyProblemError(self._miscounted(len(value), place, shared))
        return Stated(value[j], f"{place}[{j}]")

    def _miscounted(self, values: int, place: str, shared: bool) -> str:
        axis, n = self.overlay.axis, len(self.spans)
        both = f", or {self.total} for all sensors, u's first" if shared and self.total > n else ""
        return (
            f"{place}: {values} values, but axis {axis} has {n} "
            f"sensor{'' if n == 1 else 's'}; write one value, or {n}{both}"
        )


def is_each(value: Any, place: str) -> bool:
    """Tell whether a key's value is a list with one value for each sensor; a range is a pair."""
    if place.endswith(".range"):
        return isinstance(value, list) and isinstance(value[0], list)
    return isinstance(value, list)


def sensor_sets(
    table: SensorsTable, axes: Sequence[str], geometry: Geometry, precision: int
) -> dict[str, tuple[AxisSensors, tuple[Sensor, ...]]]:
    """Return the set of each axis, and its sensors one by one, named u0, u1 ... or v0, v1 ...

    Args:
        table: [sensors].
        axes: "u", "v" or both, in this order.
        geometry: of the joint.
        precision: bits of counts in the firmware, 16 or 32.

    Raises:
        KeyProblemError: "KEY: what is wrong; what would be right".
    """
    overlays = [_Overlay(table.u if axis == "u" else table.v, table, axis) for axis in axes]
    placed = [_placed(overlay, geometry) for overlay in overlays]
    total, first, sets = sum(len(spans) for _, spans in placed), 0, {}
    for axis, overlay, (placement, spans) in zip(axes, overlays, placed, strict=True):
        sets[axis] = _axis_set(_Set(overlay, placement, spans, first, total), precision)
        first += len(spans)
    return sets


def own_keys(table: SensorsTable) -> Iterator[str]:
    """Names of the tables for one axis alone and of the keys in them, in full."""
    for axis in sorted({"u", "v"} & table.model_fields_set):
        own: AxisTable = getattr(table, axis)
        yield f"sensors.{axis}"
        yield from (f"sensors.{axis}.{key}" for key in sorted(own.model_fields_set))
        keys = sorted(own.transducer.model_fields_set)
        yield from (f"sensors.{axis}.transducer.{key}" for key in keys)


def _axis_set(found: _Set, precision: int) -> tuple[AxisSensors, tuple[Sensor, ...]]:
    axis, count = found.overlay.axis, len(found.spans)
    radii = [found.radius(j) for j in range(count)]

    def made(j: int) -> Transducer:
        return transducer(lambda key: found.stated(key, j), precision)

    transducers = [made(j) for j in range(count)]
    sensors = tuple(
        sensor_of(f"{axis}{j}", found.spans[j], _ANGLES_DEG[axis], radii[j], transducers[j])
        for j in range(count)
    )
    alike = AxisSensors(
        spans=found.spans,
        radius=radii[0] if len(set(radii)) == 1 else None,
        transducer=transducers[0] if len(set(transducers)) == 1 else None,
        placement=found.placement,
    )
    return alike, sensors


def sensor_of(
    name: str, span: tuple[float, float], degrees: float, radius: float, counts: Transducer
) -> Sensor:
    """Return one sensor with a span from its first to its last segment."""
    return Sensor(
        name=name,
        start=float(span[0]),
        end=float(span[1]) + 1.0,
        angle=math.radians(degrees),
        radius=radius,
        metres_per_count=counts.metres_per_count,
        bits=counts.bits,
        signed=counts.signed,
        noise=counts.noise,
        zero=counts.zero,
        range=counts.range,
        gain_tolerance=counts.gain_tolerance,
    )


def _placed(overlay: _Overlay, geometry: Geometry) -> tuple[str, AnySpans]:
    """Return the name of the placement and its spans; the axis' own choice replaces both."""
    own, common = overlay.own, overlay.common
    for table, name in ((common, "sensors"), (own, f"sensors.{overlay.axis}")):
        _check_one_choice(table, name)
    if own.placement is not None:
        # A count for both axes may belong to another placement, then the axis needs its own.
        return _laid_out(overlay, own.placement, geometry.segments)
    if _lists_spans(own):
        return "spans", _listed(own, f"sensors.{overlay.axis}", geometry)
    if _lists_spans(common):
        return "spans", _listed(common, "sensors", geometry, overlay)
    return _laid_out(overlay, common.placement, geometry.segments)


def _lists_spans(table: AxisTable) -> bool:
    return table.spans is not None or table.spans_m is not None


def _check_one_choice(table: AxisTable, name: str) -> None:
    """Check that a table says in one way where the sensors are."""
    for key in ("spans", "spans_m"):
        if table.placement is not None and getattr(table, key) is not None:
            raise KeyProblemError(
                f"{name}.{key}: stands beside placement; remove one of them, spans alone say it all"
            )
    if table.spans is not None and table.spans_m is not None:
        raise KeyProblemError(
            f"{name}.spans_m: stands beside spans; remove one of them, either says it all"
        )


def _listed(
    table: AxisTable, name: str, geometry: Geometry, overlay: _Overlay | None = None
) -> AnySpans:
    key, count, place = "spans", table.count, f"{name}.count"
    if table.spans is not None:
        spans: AnySpans = tuple(
            segments_span(f"{name}.spans[{j}]", span, geometry.segments)
            for j, span in enumerate(table.spans)
        )
    else:
        key = "spans_m"
        spans = tuple(
            metres_span(f"{name}.spans_m[{j}]", span, geometry)
            for j, span in enumerate(table.spans_m or [])
        )
    if overlay is not None:
        count, place = overlay.get("count"), overlay.place("count")
    if count is not None and count != len(spans):
        raise KeyProblemError(
            f"{place}: {count} contradicts the spans listed; remove it, "
            f"or write count = {len(spans)}"
        )
    bare = uncovered(spans, geometry.segments)
    if bare:
        raise KeyProblemError(
            f"{name}.{key}: no span covers {segments_said(bare)}; "
            f"let the spans cover segments 0 to {geometry.segments - 1} without a gap"
        )
    return spans


def _laid_out(overlay: _Overlay, placement: str | None, segments: int) -> tuple[str, AnySpans]:
    count, place = overlay.get("count"), overlay.place("count")
    if placement == "single":
        inherited = overlay.own.placement is not None and overlay.own.count is None
        if count not in (None, 1) and not inherited:
            raise KeyProblemError(
                f'{place}: {count} sensors with placement "single"; '
                'remove it, or write placement = "heuristic"'
            )
        return placement, spans_for(placement, segments, 1)
    if count is None:
        if placement is not None:
            own = overlay.own.placement is not None
            place = f"sensors.{overlay.axis}.count" if own else "sensors.count"
            raise KeyProblemError(missing_key(place, AxisTable.model_fields["count"]))
        count = _DEFAULT_COUNT
    if count > segments:
        raise KeyProblemError(
            f"{place}: {count} sensors do not fit {segments} segment{'' if segments == 1 else 's'};"
            f" write a count from 1 to {segments}"
        )
    placement = placement or _DEFAULT_PLACEMENT
    return placement, spans_for(placement, segments, count)
