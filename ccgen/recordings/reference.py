"""Reference shapes of a recording with what its sensors read: one type for all that follows."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.recordings.gains import Sensed
from ccgen.recordings.learning import Learned
from ccgen.recordings.lengths import Read
from ccgen.recordings.recording import Recording
from ccgen.recordings.stations import Sighting, StationErrors

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

BLOCKS = 5
"""Contiguous parts of a recording that are held out one after the other."""


@dataclass(frozen=True, eq=False)
class Reference:
    """The shapes of a recording of N rows, and its sensors' readings, for m segments, S sections.

    Attributes:
        name: as errors call it, such as "recording:run1.csv".
        use: "fit" or "score".
        t: clock of the reference, shape (N,), seconds; numbers of rows where it has no times.
        dense: whether segment angles were recorded, rather than bodies.
        state: most probable u, v, h of each row, shape (N, 2m + S), radians and shares of the
            length; NaN where not known.
        covariance: of the states, with what is not known of what all rows share, shape
            (N, 2m + S, 2m + S); None where dense, and where found again without some rows.
        second_moment: of the states about zero, shape (2m + S, 2m + S).
        lengths: of the sensors from count 0 on at nominal gain, laid on the reference's clock,
            shape (N, n), metres; NaN where missing, stuck, or at the end of their range; None
            without counts.
        gain, gain_std: length = gain * (H x) + zero, shape (n,); None without counts.
        zero, zero_std: of this recording, shape (n,), metres; None without counts.
        noise: one standard deviation of a length, shape (n,), metres; None without counts.
        delay_s: by which the sensors lag, seconds; 0 without counts.
        delay_std_s: of that; 0 where it is stated, infinite where the recording does not tell.
        notes: what is to be said of the recording, a line each.
        sighting: bodies in the joint's frame, for `stations`; None as of the covariance.
        compliance: of equal parts of the joint from its base, natural logarithms, and their
            standard deviations, shape (2, parts); None where it was not learned.
        learned: what all recordings with bodies tell, from which it is learned again without some
            rows; None where dense.
    """

    name: str
    use: str
    t: Floats
    dense: bool
    state: Floats
    covariance: Floats | None
    second_moment: Floats
    lengths: Floats | None = None
    gain: Floats | None = None
    gain_std: Floats | None = None
    zero: Floats | None = None
    zero_std: Floats | None = None
    noise: Floats | None = None
    delay_s: float = 0.0
    delay_std_s: float = 0.0
    notes: tuple[str, ...] = ()
    sighting: Sighting | None = None
    compliance: Floats | None = None
    learned: Learned | None = None

    def with_readings(self, read: Read | None, sensed: Sensed | None) -> "Reference":
        """The same shapes with what was read beside them, and what is known of the sensors."""
        return replace(
            self,
            lengths=None if read is None else read.lengths,
            gain=None if sensed is None else sensed.gain,
            gain_std=None if sensed is None else sensed.gain_std,
            zero=None if sensed is None else sensed.zero,
            zero_std=None if sensed is None else sensed.zero_std,
            noise=None if read is None or sensed is None else read.own_noise(sensed.noise),
            delay_s=0.0 if read is None else read.delay.seconds,
            delay_std_s=0.0 if read is None else read.delay.std,
        )

    def stations(self, estimate: Floats) -> dict[str, StationErrors]:
        """Errors of an estimate at the stations of bodies, by name; none where it is dense.

        Args:
            estimate: shape (N, 2m + S), radians and shares; rows with a NaN are left out.
        """
        return {} if self.sighting is None else self.sighting.errors(estimate)

    @property
    def block(self) -> NDArray[np.intp]:
        """Block of each row, 0 to 4, shape (N,): sample i of N is in block 5 i // N."""
        return blocks(len(self.t))


def blocks(rows: int) -> NDArray[np.intp]:
    """Block of each of N rows, shape (N,)."""
    return BLOCKS * np.arange(rows) // max(rows, 1)


def learned_rows(recording: Recording, without_block: int | None) -> Flags:
    """From which rows of a recording to fit to something may be learned, shape (N,)."""
    if without_block is None:
        return np.ones(recording.rows, dtype=np.bool_)
    return np.asarray(blocks(recording.rows) != without_block)
