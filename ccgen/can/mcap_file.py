"""Snapshots in an MCAP file, with a JSON schema, as Foxglove and PlotJuggler open it.

What has no value is left out: a sensor without a reading, all values of an axis that is lost, all
coordinates of a tip that did not come. So every field has one type, which readers of schemas need.
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ccgen.can.layout import FrameLayout
from ccgen.can.outlets import Outlet
from ccgen.errors import ToolError

_NUMBERS = {"type": "array", "items": {"type": "number"}}
_NAMES = {"type": "array", "items": {"type": "string"}}


def schema(sensors: tuple[str, ...], axes: tuple[str, ...]) -> dict[str, Any]:
    """JSON schema of a snapshot of a joint.

    Args:
        sensors: their names.
        axes: of "u", "v" and "h".
    """
    fields: dict[str, Any] = {
        "t": {"type": "number", "description": "seconds"},
        "counter": {"type": "integer", "description": "number of the snapshot on the bus"},
        "counts": {
            "type": "object",
            "properties": {name: {"type": "integer"} for name in sensors},
            "additionalProperties": False,
        },
        "angles_deg": {
            "type": "object",
            "properties": {axis: _NUMBERS for axis in axes if axis != "h"},
            "required": [axis for axis in axes if axis != "h"],
            "additionalProperties": False,
        },
        "elongation": _NUMBERS | {"description": "share of the length, by section"},
        "tip_m": _NUMBERS | {"description": "metres in the base frame"},
        "missing": _NAMES,
        "suspected": _NAMES,
        "faults": _NAMES,
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "ccgen.Snapshot",
        "type": "object",
        "properties": fields,
        "required": list(fields),
        "additionalProperties": False,
    }


@contextmanager
def mcap_outlet(path: Path, layout: FrameLayout, axes: tuple[str, ...]) -> Iterator[Outlet]:
    """Write each snapshot to an MCAP file, which is closed properly however the block ends.

    Args:
        path: of the file; an older one is replaced.
        layout: of the joint.
        axes: that it estimates.

    Raises:
        ToolError: the package mcap is not installed.
        OSError: the file cannot be written.
    """
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise ToolError(
            "an MCAP file needs mcap; install it with `pip install 'ccgen[view]'`"
        ) from error
    with path.open("wb") as file:
        writer: Any = Writer(file)  # parts of it are not annotated
        writer.start(library="ccgen")
        described = json.dumps(schema(layout.sensors, axes)).encode("ascii")
        kind = writer.register_schema("ccgen.Snapshot", "jsonschema", described)
        channel = writer.register_channel(f"/{layout.name}/snapshot", "json", kind)

        def write(record: dict[str, Any]) -> None:
            data = json.dumps(_without_gaps(record, layout.sensors), allow_nan=False)
            stamp = round(1e9 * record["t"])
            writer.add_message(channel, stamp, data.encode("ascii"), stamp)

        try:
            yield write
        finally:
            writer.finish()


def _without_gaps(record: dict[str, Any], sensors: tuple[str, ...]) -> dict[str, Any]:
    counts = zip(sensors, record["counts"] or (), strict=False)
    return {
        "t": record["t"],
        "counter": record["counter"],
        "counts": {name: count for name, count in counts if count is not None},
        "angles_deg": {axis: _whole(values) for axis, values in record["angles_deg"].items()},
        "elongation": _whole(record["elongation"]),
        "tip_m": _whole(record["tip_m"]),
        "missing": record["missing"],
        "suspected": record["suspected"],
        "faults": record["faults"],
    }


def _whole(values: list[float | None] | None) -> list[float | None]:
    return [] if values is None or None in values else values
