"""What has come of a node's answers: a snapshot's frames, and frames that count themselves."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from ccgen.can.codec import Decoded

Content = TypeVar("Content")


@dataclass
class PendingAnswer:
    """A snapshot whose answer is on its way.

    Attributes:
        index: of the snapshot.
        sent: when, seconds of the monotonic clock.
        angles: values of each ANGLES frame that the node publishes, None until it comes.
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
class CountedStream(Generic[Content]):
    """The STATUS or the HEALTH frames, which carry a counter of their own.

    Attributes:
        modulus: of that counter.
        content: what a frame says.
        seen: contents in order.
        lost: frames that the counter shows to be missing.
    """

    modulus: int
    content: Callable[[Decoded], Content]
    seen: list[Content] = field(default_factory=list)
    lost: int = 0
    counter: int | None = None

    def take(self, decoded: Decoded) -> None:
        """Append a frame's content and count the frames between it and the one before."""
        if self.counter is not None:
            self.lost += (decoded.number - self.counter - 1) % self.modulus
        self.counter = decoded.number
        self.seen.append(self.content(decoded))
