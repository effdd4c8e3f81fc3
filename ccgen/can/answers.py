"""What has come so far of a node's answers: the frames of a snapshot, the stream of statuses."""

from dataclasses import dataclass, field

from ccgen.can.codec import Decoded, Status, status_of


@dataclass
class PendingAnswer:
    """A snapshot whose answer is on its way.

    Attributes:
        index: of the snapshot.
        sent: when, seconds of the monotonic clock.
        angles: values of each ANGLES frame, None until it comes.
        tip: values of the TIP frame, None until it comes.
        received: frames that came.
    """

    index: int
    sent: float
    angles: list[tuple[int, ...] | None]
    tip: tuple[int, ...] | None = None
    received: int = 0

    def store(self, decoded: Decoded) -> bool:
        """Put a frame's values in their place; False if some are there already."""
        if decoded.kind == "tip":
            fresh = self.tip is None
            self.tip = decoded.values
        else:
            fresh = self.angles[decoded.index] is None
            self.angles[decoded.index] = decoded.values
        self.received += fresh
        return fresh


@dataclass
class StatusStream:
    """The STATUS frames, which carry a counter of their own.

    Attributes:
        modulus: of that counter.
        seen: statuses in order.
        lost: frames that the counter shows to be missing.
    """

    modulus: int
    seen: list[Status] = field(default_factory=list)
    lost: int = 0
    counter: int | None = None

    def take(self, decoded: Decoded) -> None:
        """Append a status and count those between it and the one before."""
        if self.counter is not None:
            self.lost += (decoded.number - self.counter - 1) % self.modulus
        self.counter = decoded.number
        self.seen.append(status_of(decoded))
