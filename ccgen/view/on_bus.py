"""Snapshots of a bus as sights of a joint, held against the reference model."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ccgen.estimation.estimate import normalised_readings
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.joint import Joint
from ccgen.view.sight import Bends, Floats, Sight

_ABSENT = -(2**62)
"""A count that is no reading of any sensor."""


class BusSights:
    """Sights of one joint, from what its bus tells."""

    def __init__(self, joint: Joint, guarded: GuardedModel) -> None:
        """Begin with the straight joint.

        Args:
            joint, guarded: of the exported folder.
        """
        self._joint, self._guarded = joint, guarded
        zeros = guarded.model.readings.zero.tolist()
        self._sensors = [
            replace(sensor, zero=zero) for sensor, zero in zip(joint.sensors, zeros, strict=True)
        ]
        self._last = Bends.straight(joint)

    def sight(self, record: Mapping[str, Any], known_zero: bool) -> Sight:
        """What a snapshot shows.

        The truth is what the reference model makes of the lengths, where these are on the bus and
        no sensor is suspected, which hangs on the snapshots before.

        Args:
            record: plain values of `ccgen.can.seen.plain`.
            known_zero: whether the node is known to work with the zeros of the model.
        """
        told: dict[str, list[float | None]] = dict(record["angles_deg"])
        found = {axis: _whole(values, np.pi / 180.0) for axis, values in told.items()}
        if record["elongation"] is not None:
            found["h"] = _whole(record["elongation"], 1.0)
        there = {axis: values for axis, values in found.items() if values is not None}
        self._last = replace(self._last, **there)
        counts = self._counts(record)
        faults = tuple(name for name in record["faults"] if name != "good")
        return Sight(
            t=record["t"],
            estimate=self._last,
            readings=normalised_readings(self._joint, self._sensors, counts[None])[0],
            truth=self._reference(counts) if known_zero and not record["suspected"] else None,
            lost=tuple(axis for axis in found if axis not in there),
            missing=tuple(record["missing"]),
            suspected=tuple(record["suspected"]),
            faults=faults,
        )

    def _counts(self, record: Mapping[str, Any]) -> Floats:
        """Counts, shape (n,); NaN where there is no reading."""
        listed = record["counts"] or [None] * len(self._sensors)
        counts = np.array([np.nan if count is None else count for count in listed], dtype=float)
        counts[[sensor.name in record["missing"] for sensor in self._sensors]] = np.nan
        return counts

    def _reference(self, counts: Floats) -> Bends | None:
        if np.isnan(counts).all():
            return None
        whole = np.where(np.isnan(counts), _ABSENT, counts).astype(np.int64)[None]
        absent = self._guarded.missing(whole)
        raw = self._guarded.estimate(np.where(absent, 0, whole), absent)
        parts = {}
        for axis, values in self._guarded.model.split(raw).items():
            model = self._guarded.model.axes[axis]
            if values[0, 0] == -model.angle_limit - 1:
                return None
            parts[axis] = values[0] * 2.0**-model.fraction_bits
        return replace(Bends.straight(self._joint), **parts)


def _whole(values: list[float | None], scale: float) -> Floats | None:
    """Values of an axis; None where one is unknown."""
    there = [value for value in values if value is not None]
    return scale * np.array(there) if values and len(there) == len(values) else None
