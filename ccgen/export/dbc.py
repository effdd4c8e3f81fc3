"""The joint's frames as a DBC file, built with cantools; the same input gives the same text."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from cantools.database import Database
from cantools.database.can import Bus, Message, Node, Signal
from cantools.database.can.formats.dbc import DbcAttribute, DbcAttributeDefinition, DbcSpecifics
from cantools.database.can.formats.dbc.dbc_attribute_definition import DbcAttributeDefinitionType
from cantools.database.conversion import BaseConversion
from cantools.database.utils import sort_signals_by_start_bit
from cantools.typechecking import Choices

from ccgen import __version__
from ccgen.can import layout as frames
from ccgen.can.layout import FrameLayout, FrameSpec, Kind, Quantity
from ccgen.joint import Joint

if TYPE_CHECKING:
    from ccgen.fixedpoint import FixedPointModel

HOST = "HOST"
"""Network node that listens; those that send carry the joint's name."""

_NO_READING = "no reading"
_CYCLE_TIME = "GenMsgCycleTime"
_MAXIMUM_CYCLE_MS = 2**16 - 1

_BUS_TYPE = DbcAttributeDefinition(name="BusType", default_value="CAN", type_name="STRING")
_CYCLE = DbcAttributeDefinition(
    name=_CYCLE_TIME,
    default_value=0,
    kind="BO_",
    type_name="INT",
    minimum=0,
    maximum=_MAXIMUM_CYCLE_MS,
)
_BIT_RATE_SWITCH = DbcAttributeDefinition(
    name="CANFD_BRS", default_value="0", kind="BO_", type_name="ENUM", choices=["0", "1"]
)
_DATA_ID = DbcAttributeDefinition(
    name="E2EDataId", default_value=0, kind="BO_", type_name="INT", minimum=0, maximum=0xFFFF
)
_PROFILE = DbcAttributeDefinition(
    name="E2EProfile", default_value="", kind="BO_", type_name="STRING"
)


class _Meaning(NamedTuple):
    """What one step of a signal stands for, its comment, and the value of a raw 0."""

    scale: float
    unit: str | None
    comment: str
    offset: float = 0


def dbc_text(layout: FrameLayout, joint: Joint, model: "FixedPointModel") -> str:
    """Describe every frame of the joint: Intel byte order, SI units.

    Lengths are in metres of change against the model's zero, angles in radians, elongation in
    shares of the length, the tip in metres in the base frame. Raw values are the integers that
    sensors and estimator work with.
    """
    meanings = _meanings(layout, joint, model)
    database = Database(
        messages=[_message(layout, frame, meanings) for frame in layout.used_frames],
        nodes=[
            Node(_sensors(layout), "Reads the length sensors"),
            Node(_node(layout), "Estimates the joint's shape"),
            Node(HOST, "Uses the estimate"),
        ],
        buses=[Bus("", baudrate=joint.can.bitrate)],
        version=f"ccgen {__version__}",
        dbc_specifics=_specifics(layout),
    )
    return str(database.as_dbc_string(sort_signals=sort_signals_by_start_bit))


def _specifics(layout: FrameLayout) -> DbcSpecifics:
    definitions: OrderedDict[str, DbcAttributeDefinitionType] = OrderedDict()
    for definition in (_BUS_TYPE, _CYCLE, _PROFILE, _DATA_ID):
        definitions[definition.name] = definition
    if layout.fd:
        definitions[_BIT_RATE_SWITCH.name] = _BIT_RATE_SWITCH
    bus_type = DbcAttribute("CAN FD" if layout.fd else "CAN", _BUS_TYPE)
    return DbcSpecifics(attributes=OrderedDict(BusType=bus_type), attribute_definitions=definitions)


def _sensors(layout: FrameLayout) -> str:
    return f"{layout.name.upper()}_SENSORS"


def _node(layout: FrameLayout) -> str:
    return f"{layout.name.upper()}_JOINT"


def _message(layout: FrameLayout, frame: FrameSpec, meanings: "_Meanings") -> Message:
    receivers = [_node(layout)] if frame.kind in ("lengths", "command") else [HOST]
    return Message(
        frame_id=frame.id,
        name=frame.name,
        length=frame.length,
        signals=[_signal(signal, meanings.of(signal), receivers) for signal in frame.signals],
        comment=_FRAME_COMMENTS[frame.kind],
        senders=[_SENDERS.get(frame.kind, _node)(layout)],
        cycle_time=_cycle_time(layout, frame.kind),
        dbc_specifics=DbcSpecifics(attributes=_attributes(layout, frame)),
        is_extended_frame=layout.extended,
        is_fd=layout.fd,
        strict=True,
    )


def _attributes(layout: FrameLayout, frame: FrameSpec) -> "OrderedDict[str, DbcAttribute[Any]]":
    attributes: OrderedDict[str, DbcAttribute[Any]] = OrderedDict(
        E2EProfile=DbcAttribute("P05" if layout.fd else "P01", _PROFILE),
        E2EDataId=DbcAttribute(frame.data_id, _DATA_ID),
    )
    if layout.rate_switch:
        attributes[_BIT_RATE_SWITCH.name] = DbcAttribute("1", _BIT_RATE_SWITCH)
    return attributes


def _cycle_time(layout: FrameLayout, kind: Kind) -> int:
    """Milliseconds; 0 for what is sent when it is wanted."""
    times = {"health": frames.HEALTH_MS, "command": 0}
    return times.get(kind, min(layout.cycle_ms, _MAXIMUM_CYCLE_MS))


def _signal(signal: frames.Signal, meaning: _Meaning, receivers: list[str]) -> Signal:
    choices: Choices | None = None
    if signal.signed:
        choices = OrderedDict({signal.no_reading: _NO_READING})
    elif signal.quantity in _CHOICES:
        choices = OrderedDict(_CHOICES[signal.quantity])
    conversion = BaseConversion.factory(scale=meaning.scale, offset=meaning.offset, choices=choices)
    # Of all that the bits hold: a count beyond the sensor's range must remain to be sent.
    ends = sorted(meaning.offset + meaning.scale * raw for raw in signal.raw_range)
    return Signal(
        name=signal.name,
        start=signal.start,
        length=signal.bits,
        byte_order="little_endian",
        is_signed=signal.signed,
        conversion=conversion,
        minimum=ends[0],
        maximum=ends[1],
        unit=meaning.unit,
        comment=meaning.comment,
        receivers=receivers,
    )


_FRAME_COMMENTS: dict[Kind, str] = {
    "lengths": "Sensor counts; all LENGTHS frames of one snapshot carry the same number.",
    "angles": "Values of the axes; carries the number of its snapshot.",
    "tip": "Tip position in the base frame; carries the number of its snapshot.",
    "status": "State of the estimator, every cycle; its counter advances by one a frame.",
    "health": f"State of sensors, axes and zero, every {frames.HEALTH_MS} ms and after each "
    "command; its counter advances by one a frame.",
    "command": "Asks for a zero; a number that HEALTH tells already acts no more.",
}

_SENDERS: dict[Kind, Callable[[FrameLayout], str]] = {
    "lengths": _sensors,
    "command": lambda _: HOST,
}

_CHOICES: dict[Quantity, dict[int, str]] = {
    "axis_state": dict(enumerate(frames.AXIS_STATES)),
    "zero_state": dict(enumerate(frames.ZERO_STATES)),
    "command": frames.COMMANDS,
    "command_result": {k: name.lower() for k, name in enumerate(frames.RESULT_MEANINGS)},
}
"""What values of a signal are called."""


@dataclass(frozen=True)
class _Meanings:
    """What signals stand for: lengths by the signal's name, all else by its quantity."""

    lengths: dict[str, _Meaning]
    others: dict[Quantity, _Meaning]

    def of(self, signal: frames.Signal) -> _Meaning:
        """Return that of a signal."""
        return self.lengths.get(signal.name) or self.others[signal.quantity]


def _meanings(layout: FrameLayout, joint: Joint, model: "FixedPointModel") -> _Meanings:
    faults = ", ".join(f"{bit} {name}" for bit, name in enumerate(frames.FAULTS))
    results = ", ".join(f"{k} {text}" for k, text in enumerate(frames.RESULT_MEANINGS.values()))
    bits = zip(layout.missing_bits, layout.sensors, strict=True)
    missing = f"bits: {', '.join(f'{bit} {name}' for bit, name in bits)}"
    zeros = model.readings.zero.tolist()
    others: dict[Quantity, _Meaning] = {
        "crc": _Meaning(1, None, "CRC-16 CCITT-FALSE" if layout.fd else "CRC-8 SAE J1850"),
        "counter": _Meaning(1, None, f"0 to {layout.counter_modulus - 1}, then 0 again"),
        "turn": _Meaning(1, None, "Turns of the counter: number = turn * 15 + counter"),
        "tip": _Meaning(2.0**-layout.tip_fraction_bits, "m", _with_no_reading("Tip position", 16)),
        "sample_counter": _Meaning(1, None, "Complete snapshots since the start, modulo 65536"),
        "missing_sensors": _Meaning(1, None, f"Sensors without a reading; {missing}"),
        "faults": _Meaning(1, None, f"Since the last STATUS; bits: {faults}"),
        "age": _Meaning(0.001, "s", "Since the last complete snapshot; raw 255: that or more"),
        "fingerprint": _Meaning(1, None, f"Low 16 bits of {layout.name.upper()}_FINGERPRINT"),
        "suspected_sensors": _Meaning(1, None, f"Sensors that others contradict; {missing}"),
        "axis_state": _Meaning(1, None, "State of an output axis in the latest snapshot"),
        "zero_state": _Meaning(1, None, "Whose zero offsets the node estimates with"),
        "command_number": _Meaning(1, None, "Number of a command; the next one takes another"),
        "command_result": _Meaning(1, None, f"What became of the last command: {results}"),
        "command": _Meaning(1, None, "What is asked for"),
        "command_snapshots": _Meaning(1, None, "1 to 255: snapshots that a capture averages"),
    }
    for name, axis in model.axes.items():
        quantity, unit, said = _VALUES[name]
        text = _with_no_reading(said, 8 * layout.angle_bytes)
        others[quantity] = _Meaning(2.0**-axis.fraction_bits, unit, text)
    lengths = {
        f"{frames.LENGTH}{sensor.name}": _length(sensor.metres_per_count, zero, layout)
        for sensor, zero in zip(joint.sensors, zeros, strict=True)
    }
    return _Meanings(lengths, others)


_VALUES: dict[str, tuple[Quantity, str | None, str]] = {
    "u": ("angle_u", "rad", "Bending about local x"),
    "v": ("angle_v", "rad", "Bending about local y"),
    "h": ("elongation", None, "Elongation of a section, share of its length"),
}


def _length(metres_per_count: float, zero: int, layout: FrameLayout) -> _Meaning:
    text = _with_no_reading("Change of length, in counts of the sensor", 8 * layout.count_bytes)
    return _Meaning(metres_per_count, "m", text, -zero * metres_per_count if zero else 0)


def _with_no_reading(text: str, bits: int) -> str:
    return f"{text}; raw {-(1 << (bits - 1))}: {_NO_READING}"
