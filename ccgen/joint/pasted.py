"""Lines for a joint file whose sensors are elsewhere."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from ccgen.joint import toml
from ccgen.joint.layouts import AnySpans
from ccgen.joint.specification import Joint


def sensor_tables(joint: Joint, spans: AnySpans) -> str:
    """The [[sensor]] tables of a joint file with other spans, and all else that it says there.

    A span is told in metres too, as a comment. One that ends within a segment can only be the
    file's own, and stays as it says it.

    Args:
        joint: one whose file lists its sensors.
        spans: of its sensors.
    """
    document = toml.document(joint.content)
    tables = zip(document["sensor"], spans, strict=True)
    segment = joint.geometry.segment_length
    return "\n\n".join("\n".join(_lines(stated, span, segment)) for stated, span in tables)


def _lines(stated: Mapping[str, Any], span: tuple[float, float], segment: float) -> Iterator[str]:
    yield "[[sensor]]"
    whole = all(float(end).is_integer() for end in span)
    for key, value in stated.items():
        if whole and key in ("span", "span_m"):
            first, last = (int(end) for end in span)
            metres = f"{first * segment:.4g} to {(last + 1) * segment:.4g} m from the base"
            yield f"span = [{first}, {last}]  # {metres}"
        else:
            # A literal of these types is one in JSON.
            yield f"{key} = {json.dumps(value)}"
