"""Sensor spans from a count alone (section 2.5.1 of the paper).

A span (a, b) covers segments a to b, both included, counted from 0 at the base.
"""

Span = tuple[int, int]
Spans = tuple[Span, ...]

AnySpan = tuple[float, float]
"""A span whose ends may be fractions: (0, 4.5) covers five and a half segments, 0 to 5."""
AnySpans = tuple[AnySpan, ...]

LAYOUTS = ("single", "end-to-end", "heuristic")


def single(segments: int) -> Spans:
    """One sensor over the whole joint (SS)."""
    return ((0, segments - 1),)


def end_to_end(segments: int, sensors: int) -> Spans:
    """Spans without overlap; a remainder goes one each to the most distal sensors (EE).

    Raises:
        ValueError: fewer segments than sensors, or no sensor.
    """
    if not 1 <= sensors <= segments:
        raise ValueError(f"{sensors} sensors do not fit end to end on {segments} segments")
    share, remainder = divmod(segments, sensors)
    ends = [share * (j + 1) + max(0, j + 1 - (sensors - remainder)) for j in range(sensors)]
    starts = [0, *ends[:-1]]
    return tuple((a, b - 1) for a, b in zip(starts, ends, strict=True))


def heuristic(segments: int, sensors: int) -> Spans:
    """End-to-end spans grown by one segment at each end, clipped to the joint (HO).

    Raises:
        ValueError: fewer segments than sensors, or no sensor.
    """
    return tuple(
        (max(0, a - 1), min(segments - 1, b + 1)) for a, b in end_to_end(segments, sensors)
    )


def spans_for(layout: str, segments: int, sensors: int) -> Spans:
    """Spans of the layout with that name, one of `LAYOUTS`.

    Raises:
        ValueError: unknown name, or a count that does not fit.
    """
    if layout == "single":
        return single(segments)
    if layout == "end-to-end":
        return end_to_end(segments, sensors)
    if layout == "heuristic":
        return heuristic(segments, sensors)
    raise ValueError(f"unknown layout {layout!r}; known: {', '.join(LAYOUTS)}")
