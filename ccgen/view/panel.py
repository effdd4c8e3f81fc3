"""What stands beside the drawing: numbers, and what the colours mean."""

import html
import math
from collections.abc import Iterator

import numpy as np

from ccgen.joint import Joint
from ccgen.view.drawing import LONG, MISSING, NEUTRAL, SHORT, SUSPECTED
from ccgen.view.sight import Errors, Sight

_CELL = 'style="padding:1px 10px 1px 0"'
_NUMBER = 'style="padding:1px 0;text-align:right;font-variant-numeric:tabular-nums"'


def numbers(joint: Joint, sight: Sight, errors: Errors | None) -> str:
    """The sight in numbers, as HTML."""
    rows = "".join(
        f"<tr><td {_CELL}>{html.escape(name)}</td><td {_NUMBER}>{html.escape(value)}</td></tr>"
        for name, value in _rows(joint, sight, errors)
    )
    return _block(f'<table style="border-collapse:collapse;width:100%">{rows}</table>')


def legend(truth: str | None) -> str:
    """What lines and colours mean, as HTML; `truth` says what the ghost is."""
    ghost = "" if truth is None else f"{_line('#9a9a9a')} {html.escape(truth)}<br>"
    scale = ",".join(f"rgb{colour}" for colour in (SHORT, NEUTRAL, LONG))
    bar = (
        f'<span style="display:inline-block;width:5em;height:.6em;'
        f'background:linear-gradient(90deg,{scale})"></span>'
    )
    return _block(
        f"{_line('#000')} estimate, with "
        f'<span style="color:#c00">x</span> and <span style="color:#090">y</span> of every segment'
        f"<br>{ghost}"
        f"{bar} sensor: shorter, unbent, longer; the ends are the range of motion<br>"
        f"{_line(f'rgb{MISSING}', 'dashed')} no reading &ensp;"
        f"{_line(f'rgb{SUSPECTED}')} suspected"
    )


def _block(content: str) -> str:
    return f'<div style="padding:.3em .6em;font-size:.85em;line-height:1.5">{content}</div>'


def _line(colour: str, kind: str = "solid") -> str:
    return (
        f'<span style="display:inline-block;width:1.8em;vertical-align:middle;'
        f'border-top:3px {kind} {colour}"></span>'
    )


def _rows(joint: Joint, sight: Sight, errors: Errors | None) -> Iterator[tuple[str, str]]:
    tip = "lost" if sight.lost else " ".join(f"{1e3 * x:.1f}" for x in sight.estimate.tip(joint))
    yield "tip x y z / mm", tip
    for axis in joint.axes:
        if axis == "h":
            shares = [f"{100.0 * share:.2f}" for share in sight.estimate.h]
            yield "elongation / %", "lost" if "h" in sight.lost else " ".join(shares)
        else:
            whole = f"{math.degrees(float(getattr(sight.estimate, axis).sum())):.2f}"
            yield f"bend {axis} / deg", "lost" if axis in sight.lost else whole
    if errors is not None:
        for axis, bend in errors.bends.items():
            yield f"error {axis} / deg", f"{math.degrees(bend):.3f}"
        off = "lost" if math.isnan(errors.tip) else f"{1e3 * errors.tip:.2f}"
        yield "error tip / mm", off
    if np.isnan(sight.readings).all() and len(sight.missing) < len(joint.sensors):
        yield "readings", "not on this bus"
    yield "no reading", ", ".join(sight.missing) or "none"
    yield "suspected", ", ".join(sight.suspected) or "none"
    yield "faults", ", ".join(sight.faults) or "none"
