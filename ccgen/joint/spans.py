"""Spans that a file lists, in segments or in metres, and whether they cover the joint."""

from collections.abc import Iterator, Sequence

from ccgen.joint.layouts import AnySpan, AnySpans
from ccgen.joint.messages import KeyProblemError, toml_value
from ccgen.joint.specification import Geometry

_NEAR = 1e-9
"""Share of a segment by which a border in metres may miss that of a segment."""


def segments_span(key: str, span: Sequence[int], segments: int) -> AnySpan:
    """Return a span [first, last] of segments, both included.

    Raises:
        KeyProblemError: it is reversed or lies outside the joint.
    """
    first, last = span
    if first > last:
        raise KeyProblemError(f"{key}: span [{first}, {last}] is reversed; write [{last}, {first}]")
    if first < 0 or last >= segments:
        raise KeyProblemError(
            f"{key}: span [{first}, {last}] lies outside the joint; "
            f"write segments from 0 to {segments - 1}"
        )
    return first, last


def metres_span(key: str, span: Sequence[float], geometry: Geometry) -> AnySpan:
    """Return a span in metres as its first and last segment; one covered in part is a fraction.

    Raises:
        KeyProblemError: it is reversed, empty, or lies outside the joint.
    """
    said = f"{key}: span {toml_value(list(span))}"
    start, end = (_border(value, geometry) for value in span)
    if start > end:
        raise KeyProblemError(f"{said} is reversed; write {toml_value(list(span)[::-1])}")
    if start == end:
        raise KeyProblemError(f"{said} is empty; write where it begins and where it ends, in m")
    if end > geometry.segments:
        raise KeyProblemError(
            f"{said} lies outside the joint; write metres from 0 at the base to "
            f"{geometry.length} at the tip (geometry.length)"
        )
    whole = start.is_integer() and end.is_integer()
    return (int(start), int(end) - 1) if whole else (start, end - 1.0)


def _border(metres: float, geometry: Geometry) -> float:
    """Place along the joint in segments; on the border of a segment where it is all but there."""
    border = metres / geometry.segment_length
    return float(round(border)) if abs(border - round(border)) <= _NEAR else border


def uncovered(spans: AnySpans, segments: int) -> list[int]:
    """Segments of which no span covers any part, ascending."""
    return [i for i in range(segments) if not any(a < i + 1 and i < b + 1 for a, b in spans)]


def segments_said(indices: list[int]) -> str:
    """Return ascending numbers of segments in words: "segments 3, 6 to 11"."""
    runs = ", ".join(str(a) if a == b else f"{a} to {b}" for a, b in _runs(indices))
    return f"segment{'' if len(indices) == 1 else 's'} {runs}"


def _runs(indices: list[int]) -> Iterator[tuple[int, int]]:
    """Yield the runs of consecutive numbers in an ascending list, as first and last."""
    first = last = indices[0]
    for index in indices[1:]:
        if index != last + 1:
            yield first, last
            first = index
        last = index
    yield first, last
