"""The sensors of one axis: what [sensors] says for both, with the axis' own keys in its place."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ccgen.joint.layouts import Span, Spans, spans_for
from ccgen.joint.messages import KeyProblemError, missing_key
from ccgen.joint.specification import AxisSensors, Sensor, Transducer
from ccgen.joint.tables import AxisTable, SensorsTable, TransducerTable

_DEFAULT_BITS = 16
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

    def transducer(self, key: str) -> Any:
        value = getattr(self.own.transducer, key)
        return getattr(self.common.transducer, key) if value is None else value

    def place(self, key: str) -> str:
        """Return the full name of the key that `get` answers from."""
        own = getattr(self.own, key) is not None
        return f"sensors.{self.axis}.{key}" if own else f"sensors.{key}"

    def transducer_place(self, key: str) -> str:
        own = getattr(self.own.transducer, key) is not None
        return f"sensors.{self.axis}.transducer.{key}" if own else f"sensors.transducer.{key}"


def axis_sensors(table: SensorsTable, axis: str, segments: int, precision: int) -> AxisSensors:
    """Return the sensors of `axis` ("u" or "v").

    Raises:
        KeyProblemError: "KEY: what is wrong; what would be right".
    """
    overlay = _Overlay(table.u if axis == "u" else table.v, table, axis)
    placement, spans = _placed(overlay, segments)
    radius = overlay.get("radius")
    if radius is None:
        raise KeyProblemError(missing_key("sensors.radius", AxisTable.model_fields["radius"]))
    transducer = _transducer(overlay, precision)
    return AxisSensors(spans, radius, transducer, placement)


def own_keys(table: SensorsTable) -> Iterator[str]:
    """Names of the tables for one axis alone and of the keys in them, in full."""
    for axis in sorted({"u", "v"} & table.model_fields_set):
        own: AxisTable = getattr(table, axis)
        yield f"sensors.{axis}"
        yield from (f"sensors.{axis}.{key}" for key in sorted(own.model_fields_set))
        keys = sorted(own.transducer.model_fields_set)
        yield from (f"sensors.{axis}.transducer.{key}" for key in keys)


def sensor_list(axis: str, sensors: AxisSensors) -> tuple[Sensor, ...]:
    """The sensors of the paper's set for `axis` one by one, named u0, u1 ... or v0, v1 ..."""
    transducer = sensors.transducer
    return tuple(
        Sensor(
            name=f"{axis}{j}",
            start=float(first),
            end=float(last + 1),
            angle=math.radians(_ANGLES_DEG[axis]),
            radius=sensors.radius,
            metres_per_count=transducer.metres_per_count,
            bits=transducer.bits,
            noise=transducer.noise,
            range=transducer.range,
        )
        for j, (first, last) in enumerate(sensors.spans)
    )


def _placed(overlay: _Overlay, segments: int) -> tuple[str, Spans]:
    """Return the name of the placement and its spans; the axis' own choice replaces both."""
    own, common = overlay.own, overlay.common
    for table, name in ((common, "sensors"), (own, f"sensors.{overlay.axis}")):
        if table.placement is not None and table.spans is not None:
            raise KeyProblemError(
                f"{name}.spans: stands beside placement; remove one of them, spans alone say it all"
            )
    if own.placement is not None:
        # A count for both axes may belong to another placement, then the axis needs its own.
        return _laid_out(overlay, own.placement, segments)
    if own.spans is not None:
        return "spans", _listed(own, f"sensors.{overlay.axis}", segments)
    if common.spans is not None:
        return "spans", _listed(common, "sensors", segments, overlay)
    return _laid_out(overlay, common.placement, segments)


def _listed(table: AxisTable, name: str, segments: int, overlay: _Overlay | None = None) -> Spans:
    spans = table.spans or []
    for j, (first, last) in enumerate(spans):
        _check_span(f"{name}.spans[{j}]", first, last, segments)
    count, place = table.count, f"{name}.count"
    if overlay is not None:
        count, place = overlay.get("count"), overlay.place("count")
    if count is not None and count != len(spans):
        raise KeyProblemError(
            f"{place}: {count} contradicts the spans listed; remove it, "
            f"or write count = {len(spans)}"
        )
    checked: Spans = tuple((first, last) for first, last in spans)
    uncovered = [i for i in range(segments) if not any(a <= i <= b for a, b in checked)]
    if uncovered:
        raise KeyProblemError(
            f"{name}.spans: no span covers {_segments(uncovered)}; "
            f"let the spans cover segments 0 to {segments - 1} without a gap"
        )
    return checked


def _check_span(key: str, first: int, last: int, segments: int) -> None:
    if first > last:
        raise KeyProblemError(f"{key}: span [{first}, {last}] is reversed; write [{last}, {first}]")
    if first < 0 or last >= segments:
        raise KeyProblemError(
            f"{key}: span [{first}, {last}] lies outside the joint; "
            f"write segments from 0 to {segments - 1}"
        )


def _laid_out(overlay: _Overlay, placement: str | None, segments: int) -> tuple[str, Spans]:
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
            f"{place}: {count} sensors do not fit {_counted(segments)}; "
            f"write a count from 1 to {segments}"
        )
    placement = placement or _DEFAULT_PLACEMENT
    return placement, spans_for(placement, segments, count)


def _transducer(overlay: _Overlay, precision: int) -> Transducer:
    bits = overlay.transducer("bits") or _DEFAULT_BITS
    if bits > precision:
        raise KeyProblemError(
            f"{overlay.transducer_place('bits')}: {bits} bits do not fit precision = {precision}; "
            f"write at most {precision}" + (", or precision = 32" if precision == 16 else "")
        )
    metres_per_count = overlay.transducer("metres_per_count")
    if metres_per_count is None:
        raise KeyProblemError(
            missing_key(
                "sensors.transducer.metres_per_count",
                TransducerTable.model_fields["metres_per_count"],
            )
        )
    limits: list[int] | None = overlay.transducer("range")
    if limits is not None:
        _check_range(overlay.transducer_place("range"), limits[0], limits[1], bits)
    return Transducer(
        bits=bits,
        metres_per_count=metres_per_count,
        noise=overlay.transducer("noise"),
        range=None if limits is None else (limits[0], limits[1]),
    )


def _check_range(key: str, low: int, high: int, bits: int) -> None:
    """Check a range of counts; the most negative count of `bits` means "no reading"."""
    largest = 2 ** (bits - 1) - 1
    said = f"{key}: range [{low}, {high}]"
    if low > high:
        raise KeyProblemError(f"{said} is reversed; write [{high}, {low}]")
    if low == high:
        raise KeyProblemError(
            f"{said} holds one count only; write the lowest and the highest count"
        )
    if low < -largest or high > largest:
        raise KeyProblemError(
            f"{said} exceeds {bits} bits, whose lowest count means no reading; "
            f"write counts from {-largest} to {largest}"
        )
    if not low <= 0 <= high:
        raise KeyProblemError(
            f"{said} leaves out 0, the count of the straight joint; "
            "write a lowest count of 0 or less and a highest of 0 or more"
        )


def _segments(indices: list[int]) -> str:
    runs = ", ".join(str(a) if a == b else f"{a} to {b}" for a, b in _runs(indices))
    return f"segment{'' if len(indices) == 1 else 's'} {runs}"


def _runs(indices: list[int]) -> Iterator[Span]:
    """Yield the runs of consecutive numbers in an ascending list, as first and last."""
    first = last = indices[0]
    for index in indices[1:]:
        if index != last + 1:
            yield first, last
            first = index
        last = index
    yield first, last


def _counted(segments: int) -> str:
    return f"{segments} segment{'' if segments == 1 else 's'}"
