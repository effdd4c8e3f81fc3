"""The specification of a joint: what every later stage reads, and nothing that computes.

Angles are in radians and lengths in metres here; `joint.toml` holds degrees and metres. Reading
and checking that file is the business of `ccgen.joint.file`, which is imported when a file is
read: importing this module costs nothing.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

from ccgen.joint.layouts import AnySpans
from ccgen.joint.loads import LoadRanges

AXES = ("u", "v")
"""The bending axes: u about local x, v about local y."""

OUTPUT_AXES = (*AXES, "h")
"""What may be estimated: the bending axes, and the elongation of sections."""

CASES = ("end-force", "uniform", "s-shape", "constant-curvature")
"""The load cases whose shapes the weights are fitted to."""

METHODS = ("direct", "equal", "wam", "noise-aware")
"""The estimation methods: DEM, E-WAM, WAM, and WAM that knows the sensors' noise."""


@dataclass(frozen=True)
class Geometry:
    """A joint of equal constant-curvature segments, in sections that elongate alike."""

    segments: int
    length: float
    """Neutral axis of the whole joint at no elongation, metres."""
    range_of_motion: float
    """Largest bending per segment and axis, radians."""
    sections: tuple[int, ...] = ()
    """Segments of each section from the base; left out: one section of all segments."""
    elongation: tuple[float, float] | None = None
    """Lowest and highest elongation of a section, share of its length; None: none."""

    def __post_init__(self) -> None:
        if not self.sections:
            object.__setattr__(self, "sections", (self.segments,))

    @property
    def segment_length(self) -> float:
        """Neutral axis of one segment at no elongation, metres."""
        return self.length / self.segments


def count_limits(bits: int, signed: bool) -> tuple[int, int]:
    """Lowest and highest count; the most negative one of a signed count means "no reading"."""
    return (-(2 ** (bits - 1)) + 1, 2 ** (bits - 1) - 1) if signed else (0, 2**bits - 1)


STATED, CALIBRATED, RECORDED = "zero", "calibration", "recordings"
"""Where a zero comes from, by the key of the joint file."""


@dataclass(frozen=True)
class Sensor:
    """One length sensor along the joint: where it runs, and what turns its length into counts."""

    name: str
    start: float
    """Border of the span nearer to the base, in segments from the base; a share of one counts."""
    end: float
    """Border of the span nearer to the tip, in segments from the base."""
    angle: float
    """Around the neutral axis from +x, counter-clockwise seen from the tip, radians."""
    radius: float
    """Distance from the neutral axis, metres."""
    metres_per_count: float
    """Negative where the count falls as the sensor lengthens."""
    bits: int
    signed: bool = True
    noise: float | None = None
    """One standard deviation of the length, metres; None when unknown."""
    zero: int | None = None
    """Count of the straight joint; None when unknown."""
    range: tuple[int, int] | None = None
    """Lowest and highest count of a reading; None for what the shapes need and a quarter more."""
    gain_tolerance: float = 0.0
    """One standard deviation of the gain, share of it."""
    zero_origin: str = field(default=STATED, compare=False)
    """Where the zero comes from: for messages only."""

    @property
    def segments(self) -> float:
        """Number p of segments that the span covers; one covered in part counts by its share."""
        return self.end - self.start


@dataclass(frozen=True)
class Transducer:
    """What turns a change of length into counts."""

    bits: int
    metres_per_count: float
    """Negative where the count falls as the sensor lengthens."""
    noise: float | None
    """One standard deviation of the length, metres; None when unknown."""
    range: tuple[int, int] | None
    """Lowest and highest count of a reading; None for what the shapes need and a quarter more."""
    signed: bool = True
    """Whether counts have a sign; if not, they run from 0."""
    zero: int | None = None
    """Count of the straight joint; None when unknown."""
    gain_tolerance: float = 0.0
    """One standard deviation of the gain, share of it."""


@dataclass(frozen=True)
class AxisSensors:
    """The paper's set of length sensors for one bending axis, all at one angle."""

    spans: AnySpans
    radius: float | None
    """Distance of the tendons from the neutral axis, metres; None where it differs among them."""
    transducer: Transducer | None
    """What all of them have; None where it differs among them."""
    placement: str
    """Name of the layout that gave the spans, or "spans" where the file lists them."""


@dataclass(frozen=True)
class ShapeSettings:
    """The shapes to fit to and to score with."""

    cases: tuple[str, ...]
    fit_samples: int
    """Amplitudes per load case (eq. 6) that the weights are fitted to."""
    score_samples: int
    """Amplitudes per load case (eq. 6) that the estimate is scored on."""
    weight: tuple[tuple[str, float], ...] = ()
    """Weight of "cases", "loads" or "recordings", each as a whole, where the file states one."""


@dataclass(frozen=True)
class RecordingFile:
    """One of [[recordings]]: which files hold a recording of the joint, and what is known of it."""

    file: str
    """The table of samples, as the joint file names it; `path` finds it."""
    folder: Path = field(compare=False)
    """The joint file's, from which paths lead."""
    use: str
    """"fit" or "score"."""
    counts: str | None = None
    """The file that holds the counts, where `file` does not."""
    dbc: str | None = None
    """What describes `counts` where that is a CAN log."""
    stations: tuple[tuple[str, float], ...] = ()
    """Bodies and markers with their places along the neutral axis, metres from the base."""
    straight: tuple[float, float] | None = None
    """When the joint was straight, seconds."""
    zero_from: tuple[float, float] | None = None
    """When the reference's own shape sets the sensors' zeros, seconds."""
    base: tuple[str, str] | None = None
    """Markers whose chord is the base frame of every row."""
    position_noise: float | None = None
    """One standard deviation of a coordinate, metres; None when unknown."""
    orientation_noise: float | None = None
    """One standard deviation about an axis, radians; None when unknown."""
    delay: float | None = None
    """Seconds by which the sensors lag; None where it is to be estimated."""
    rows: tuple[int, int] | None = None
    """First and last row to use, both included, counted from 0 behind the header."""

    def path(self, name: str) -> Path:
        """Where a file of this recording is: `file`, `counts` or `dbc`."""
        return self.folder / name


PUBLISHED = ("angles", "tip", "status", "health")
"""Kinds of frames that a node may send, in the order of their identifiers."""


@dataclass(frozen=True)
class Can:
    """The joint's place on the bus."""

    base_id: int
    extended: bool
    fd: bool
    bitrate: int
    """Bits per second; on CAN FD that of the arbitration."""
    cycle_ms: int
    turn: bool = True
    """Whether senders set the turn that numbers their snapshots on classic CAN."""
    publish: tuple[str, ...] = PUBLISHED
    """Those of `PUBLISHED` that the node sends."""
    rate_switch: bool = False
    """Whether frames switch to the faster bit rate for data; CAN FD only."""
    commands: bool = False
    """Whether the node obeys COMMAND frames."""


@dataclass(frozen=True)
class Joint:
    """A checked joint file."""

    name: str
    geometry: Geometry
    sensors: tuple[Sensor, ...]
    """All length sensors, in the order of counts everywhere; of the paper's sets u's, then v's."""
    axes: tuple[str, ...]
    """Output axes in the order "u", "v", "h": bending about x, about y, elongation."""
    parts: tuple[tuple[int, int], ...]
    """For each output axis the first sensor that it reads and the one after the last."""
    u: AxisSensors | None
    """The paper's set for u; None where the file lists its sensors one by one."""
    v: AxisSensors | None
    """The paper's set for v; None where the file lists its sensors one by one."""
    shapes: ShapeSettings
    method: str
    precision: int
    """Bits of counts, weights and angles in the firmware: 16 or 32."""
    can: Can
    source: str = field(compare=False)
    """The file as the user named it: for messages only, never part of an output."""
    content: bytes = field(default=b"", compare=False, repr=False)
    """What the file holds."""
    own_keys: frozenset[str] = field(default=frozenset(), compare=False)
    """Tables of the file for one axis or sensor alone, and the keys in them, in full: "sensors.v",
    "sensors.v.transducer.noise"; `ccgen.joint.places` tells where a value stands."""
    fallback: bool = True
    """Whether weights serve while a sensor gives no reading."""
    check: bool = True
    """Whether sensors are held against each other."""
    false_alarms: float = 1e-6
    """Of that check, share of the snapshots."""
    float_kinematics: bool = True
    """Whether single-precision poses and Jacobian are exported beside those in integers."""
    recordings: tuple[RecordingFile, ...] = ()
    loads: LoadRanges | None = None
    """What the joint meets at work; None where the file does not say."""
    calibration: str | None = None
    """The calibration file that the joint file names; `sensors` have its gains, zeros and noise."""
    calibration_content: bytes = field(default=b"", compare=False, repr=False)
    """What that holds; nothing where none was read."""

    @property
    def couples(self) -> bool:
        """Whether some sensor tells of more than one output axis, or some axis elongates."""
        ends = sorted(self.parts)
        overlap = any(b[0] < a[1] for a, b in pairwise(ends))
        return overlap or self.geometry.elongation is not None

    def axis(self, name: str) -> AxisSensors:
        """Return the paper's set of sensors for axis "u" or "v".

        Raises:
            ValueError: another name, or a joint that lists its sensors one by one.
        """
        sets = {"u": self.u, "v": self.v}
        if name not in sets:
            raise ValueError(f"unknown axis {name!r}; known: {', '.join(AXES)}")
        found = sets[name]
        if found is None:
            raise ValueError(f"joint {self.name} has no set of sensors for axis {name} alone")
        return found

    def rows(self, axis: str) -> slice:
        """Return the part of a state (u, v, h) that an output axis is, one number a row.

        Raises:
            ValueError: an unknown axis.
        """
        m, sections = self.geometry.segments, len(self.geometry.sections)
        parts = {"u": slice(0, m), "v": slice(m, 2 * m), "h": slice(2 * m, 2 * m + sections)}
        if axis not in parts:
            raise ValueError(f"unknown axis {axis!r}; known: {', '.join(parts)}")
        return parts[axis]

    def members(self, axis: str) -> slice:
        """Return the part of `sensors` that is the paper's set for axis "u" or "v".

        Raises:
            ValueError: as `axis`.
        """
        first = len(self.u.spans) if axis == "v" and self.u is not None else 0
        return slice(first, first + len(self.axis(axis).spans))

    def own(self, axis: str) -> slice:
        """Return the part of `sensors` that an output axis reads.

        Raises:
            ValueError: an axis that is not estimated.
        """
        if axis not in self.axes:
            raise ValueError(f"axis {axis!r} is not estimated; known: {', '.join(self.axes)}")
        return slice(*self.parts[self.axes.index(axis)])
