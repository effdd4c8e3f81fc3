"""What SIGTERM does: it ends the program by way of every clean-up."""

from types import FrameType


def terminate(signum: int, frame: FrameType | None) -> None:
    """Handle a signal by leaving with the status that a shell gives to it."""
    raise SystemExit(128 + signum)
