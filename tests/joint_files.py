"""Joint files for tests: a working one, with what a test is about in its place."""

_TEMPLATE = """\
name = "{name}"
[geometry]
segments = {segments}
length = {length}
range_of_motion = {range_of_motion}
[sensors]
placement = "heuristic"
count = {count}
radius = {radius}
[sensors.transducer]
bits = {bits}
metres_per_count = {step}
{transducer}
[fixed_point]
precision = {precision}
{tables}
"""


def joint_text(
    name="shoulder",
    segments=12,
    count=3,
    precision=16,
    bits=None,
    step=2.0e-6,
    length=0.24,
    range_of_motion=3.0,
    radius=0.05,
    transducer="",
    tables="",
):
    """Text of a joint file.

    Args:
        bits: of a count; as many as the precision unless given.
        step: metres per count.
        transducer: more keys of [sensors.transducer], and tables of one axis.
        tables: more tables, at the end.
    """
    return _TEMPLATE.format(**{**locals(), "bits": bits or precision})
