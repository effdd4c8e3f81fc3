"""What a verification found, one record a transport."""

import math
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Run:
    """A comparison of the C with the models over one transport.

    Attributes:
        target: "host" or a microcontroller's core.
        transport: how counts went to the C and angles came back.
        snapshots: sets of readings that were estimated.
        compared_values: angles compared with the integer reference model.
        mismatches: those that differ, by a single bit or more.
        lost_frames: frames that should have come and did not, or came damaged.
        rate_hz: snapshots a second.
        pose_max_error_m: largest distance of a pose's position from double precision, metres;
            None where the folder has no poses in floating point.
        pose_bound_m: what that distance must stay below; None likewise.
        note: what else failed, empty if nothing did.
        degraded_snapshots: those of the snapshots in which some axis is degraded or lost.
        compared_poses: poses, tip Jacobians and TIP frames in integers, compared likewise.
        pose_mismatches: those that differ, by a single bit or more.
        compared_functions: results of the user's own functions, compared likewise.
        function_mismatches: those that differ.
    """

    target: str
    transport: str
    snapshots: int
    compared_values: int
    mismatches: int
    lost_frames: int
    rate_hz: float
    pose_max_error_m: float | None
    pose_bound_m: float | None
    note: str = ""
    degraded_snapshots: int = 0
    compared_poses: int = 0
    pose_mismatches: int = 0
    compared_functions: int = 0
    function_mismatches: int = 0

    @property
    def passed(self) -> bool:
        """Whether every check held."""
        return (
            self.compared_values > 0
            and self.mismatches == 0
            and self.pose_mismatches == self.function_mismatches == 0
            and self.lost_frames == 0
            and self._poses_hold()
            and not self.note
        )

    def record(self) -> dict[str, Any]:
        """Plain values for JSON; a pose that is no number at all has no error to tell."""
        error = self.pose_max_error_m
        told = error if error is not None and math.isfinite(error) else None
        return asdict(self) | {"pose_max_error_m": told, "passed": self.passed}

    def _poses_hold(self) -> bool:
        if self.pose_max_error_m is None or self.pose_bound_m is None:
            return True
        return self.pose_max_error_m <= self.pose_bound_m
