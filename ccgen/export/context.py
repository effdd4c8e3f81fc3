"""What the templates are filled with: plain values, no decisions left to a template."""

import math
from typing import Any

from ccgen import FORMAT_VERSION, __version__
from ccgen.can.fingerprint import fingerprint
from ccgen.can.layout import COMMANDS, FAULT_MEANINGS, HEALTH_MS, RESULT_MEANINGS, FrameLayout
from ccgen.can.load import load_percent
from ccgen.digits import at_least
from ccgen.e2e import p01_key
from ccgen.export.literals import float_literal
from ccgen.export.worked_frames import worked_snapshot
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.joint import Joint
from ccgen.sensing.noise import still_counts


def common_context(joint: Joint, method: str) -> dict[str, Any]:
    """Names, versions and the joint's geometry."""
    geometry = joint.geometry
    return {
        "name": joint.name,
        "NAME": joint.name.upper(),
        "version": __version__,
        "format_version": FORMAT_VERSION,
        "segments": geometry.segments,
        "length_m": geometry.length,
        "segment_length_mm": f"{1000.0 * geometry.segment_length:.6g}",
        "rom_deg": f"{math.degrees(geometry.range_of_motion):.6g}",
        "method": method,
        "precision": joint.precision,
    }


def can_context(layout: FrameLayout, joint: Joint, guarded: GuardedModel) -> dict[str, Any]:
    """The layout of the frames, and the tables of them for headers and the folder's README."""
    bits = [f"CCGEN_PUBLISH_{kind.upper()}" for kind in layout.publish]
    ranges = guarded.model.readings
    still = still_counts(joint, ranges.moved).tolist()
    return {
        "fingerprint": fingerprint(guarded, layout),
        "publish": " | ".join(bits) or "0",
        "health_ms": HEALTH_MS,
        "commands": COMMANDS,
        "results": list(RESULT_MEANINGS.items()),
        "capture": {
            "minimum": [f"INT32_C({count})" for count in ranges.minimum.tolist()],
            "maximum": [f"INT32_C({count})" for count in ranges.maximum.tolist()],
            "still": [f"INT32_C({count})" for count in still],
        },
        "layout": layout,
        "worked": worked_snapshot(layout, ranges.zero.tolist()),
        "frame_keys": _rows([f"0x{p01_key(frame.data_id):02X}u" for frame in layout.frames]),
        "faults": list(FAULT_MEANINGS.items()),
        "bitrate": joint.can.bitrate,
        "bus_load_percent": at_least(load_percent(layout, joint.can.bitrate)),
        "profile": "P05" if layout.fd else "P01",
        "tip_metres_per_step": float_literal(2.0**-layout.tip_fraction_bits),
        "tip_steps_per_metre": float_literal(2.0**layout.tip_fraction_bits),
    }


def _rows(words: list[str], width: int = 12) -> list[list[str]]:
    """Words of a table in C, so many a line."""
    return [words[k : k + width] for k in range(0, len(words), width)]
