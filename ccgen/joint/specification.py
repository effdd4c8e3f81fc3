"""The specification of a joint: what every later stage reads, and nothing that computes.

Angles are in radians and lengths in metres here; `joint.toml` holds degrees and metres. Reading
and checking that file is the business of `ccgen.joint.file`, which is imported when a file is
read: importing this module costs nothing.
"""

from dataclasses import dataclass, field
from pathlib import Path

from ccgen.joint.layouts import Spans

AXES = ("u", "v")
"""The bending axes: u about local x, v about local y."""

CASES = ("end-force", "uniform", "s-shape", "constant-curvature")
"""The load cases whose shapes the weights are fitted to."""

METHODS = ("direct", "equal", "wam", "noise-aware")
"""The estimation methods: DEM, E-WAM, WAM, and WAM that knows the sensors' noise."""


@dataclass(frozen=True)
class Geometry:
    """A joint of equal constant-curvature segments."""

    segments: int
    length: float
    """Neutral axis of the whole joint, metres."""
    range_of_motion: float
    """Largest bending per segment and axis, radians."""

    @property
    def segment_length(self) -> float:
        """Neutral axis of one segment, metres."""
        return self.length / self.segments


@dataclass(frozen=True)
class Transducer:
    """What turns a change of length into signed counts."""

    bits: int
    metres_per_count: float
    noise: float | None
    """One standard deviation of the length, metres; None when unknown."""
    range: tuple[int, int] | None
    """Lowest and highest count of a reading; None for what the shapes need and a quarter more."""
    own: frozenset[str] = field(default=frozenset(), compare=False)
    """Keys that the axis has in a table of its own."""

    def key(self, axis: str, name: str) -> str:
        """Full name of the key in the joint file that axis "u" or "v" has a value from."""
        table = f"sensors.{axis}" if name in self.own else "sensors"
        return f"{table}.transducer.{name}"


@dataclass(frozen=True)
class AxisSensors:
    """The length sensors of one bending axis."""

    spans: Spans
    radius: float
    """Distance of the tendons from the neutral axis, metres."""
    transducer: Transducer
    placement: str
    """Name of the layout that gave the spans, or "spans" where the file lists them."""
    own_table: bool = field(default=False, compare=False)
    """Whether the joint file has a table for this axis alone."""


@dataclass(frozen=True)
class Shapes:
    """The shapes to fit to and to score with."""

    cases: tuple[str, ...]
    fit_samples: int
    """Amplitudes per load case (eq. 6) that the weights are fitted to."""
    score_samples: int
    """Amplitudes per load case (eq. 6) that the estimate is scored on."""


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


@dataclass(frozen=True)
class Can:
    """The joint's place on the bus."""

    base_id: int
    extended: bool
    fd: bool
    bitrate: int
    """Bits per second; on CAN FD that of the arbitration."""
    cycle_ms: int


@dataclass(frozen=True)
class Joint:
    """A checked joint file."""

    name: str
    geometry: Geometry
    u: AxisSensors
    v: AxisSensors
    shapes: Shapes
    method: str
    precision: int
    """Bits of counts, weights and angles in the firmware: 16 or 32."""
    can: Can
    source: str = field(compare=False)
    """The file as the user named it: for messages only, never part of an output."""
    recordings: tuple[RecordingFile, ...] = ()

    def axis(self, name: str) -> AxisSensors:
        """Return the sensors of axis "u" or "v".

        Raises:
            ValueError: another name.
        """
        if name not in AXES:
            raise ValueError(f"unknown axis {name!r}; known: {', '.join(AXES)}")
        return self.u if name == "u" else self.v
