"""[[sensor]], lists in [sensors], spans in metres, axes and elongation: what they mean, and what is
refused in one line.
"""

import math

import pytest
from joint_files import joint_text

from ccgen.errors import InputError
from ccgen.joint.file import parse_joint

ROUND = """\
name = "round"
[geometry]
segments = 12
length = 0.24
range_of_motion = 5.0
elongation = [0.0, 0.04]
[sensors.transducer]
bits = 12
signed = false
metres_per_count = 2.4e-5
noise = 1.0e-4
zero = 2048
[[sensor]]
name = "near"
span = [0, 5]
angle = 90
radius = 0.03
[[sensor]]
name = "far_left"
span_m = [0.0, 0.24]
angle = 210.0
radius = 0.031
metres_per_count = -1.2e-5
zero = 100
gain_tolerance = 0.02
[[sensor]]
name = "far_right"
span_m = [0.05, 0.24]
angle = -30.0
radius = 0.03
bits = 10
range = [3, 1000]
zero = 512
[[sensor]]
name = "back"
span = [0, 11]
angle = 90.0
radius = 0.03
"""


def edited(*pairs):
    text = ROUND
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


def refusal(text):
    with pytest.raises(InputError) as refused:
        parse_joint(text, "round.toml")
    message = str(refused.value)
    assert "\n" not in message
    assert message.startswith("round.toml: ")
    return message.removeprefix("round.toml: ")


# ---- [[sensor]] ------------------------------------------------------------------------------


def test_sensors_stand_anywhere_with_transducers_of_their_own():
    joint = parse_joint(ROUND, "round.toml")
    near, left, right, back = joint.sensors
    assert [one.name for one in joint.sensors] == ["near", "far_left", "far_right", "back"]
    assert (near.start, near.end, near.segments) == (0.0, 6.0, 6.0)
    assert (left.start, left.end) == (0.0, 12.0)
    assert (right.start, right.end) == (2.5, 12.0)
    assert [math.degrees(one.angle) for one in joint.sensors] == pytest.approx([90, 210, -30, 90])
    assert (near.signed, near.bits, near.zero, near.noise) == (False, 12, 2048, 1e-4)
    assert (left.metres_per_count, left.zero, left.gain_tolerance) == (-1.2e-5, 100, 0.02)
    assert (right.bits, right.range, right.zero) == (10, (3, 1000), 512)
    assert (back.range, back.gain_tolerance) == (None, 0.0)


def test_where_elongation_reaches_all_sensors_every_axis_reads_all_of_them():
    joint = parse_joint(ROUND, "round.toml")
    assert joint.axes == ("u", "v", "h")
    assert [joint.own(axis) for axis in joint.axes] == [slice(0, 4)] * 3
    assert joint.couples
    assert joint.geometry.sections == (12,)
    assert joint.geometry.elongation == (0.0, 0.04)
    assert (joint.u, joint.v) == (None, None)


def square(angles=(90, 270, 0, 180), tables=""):
    sensors = "".join(
        f'[[sensor]]\nname = "s{j}"\nspan = [0, 11]\nangle = {angle}\nradius = 0.03\n'
        for j, angle in enumerate(angles)
    )
    return (
        'name = "square"\n[geometry]\nsegments = 12\nlength = 0.24\nrange_of_motion = 3.0\n'
        f"[sensors.transducer]\nmetres_per_count = 2e-6\n{tables}\n{sensors}"
    )


def test_opposite_pairs_without_elongation_are_read_axis_by_axis():
    joint = parse_joint(square(), "square.toml")
    assert [joint.own(axis) for axis in joint.axes] == [slice(0, 2), slice(2, 4)]
    assert not joint.couples


def test_axes_whose_sensors_do_not_follow_each_other_read_all_sensors():
    joint = parse_joint(square((90, 0, 270, 180)), "square.toml")
    assert [joint.own(axis) for axis in joint.axes] == [slice(0, 4)] * 2


def test_a_planar_arm_leaves_an_axis_out():
    joint = parse_joint(square((0, 180), '[estimator]\naxes = ["v"]'), "square.toml")
    assert (joint.axes, joint.parts) == (("v",), ((0, 2),))
    both = joint_text(tables='[estimator]\naxes = ["v"]')
    sets = parse_joint(both, "shoulder.toml")
    assert [one.name for one in sets.sensors] == ["v0", "v1", "v2"]
    assert sets.u is None
    assert sets.own("v") == slice(0, 3)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            [('"back"', '"near"')],
            'sensor[3].name: "near" is the name of sensor[0]; give each sensor a name of its own',
        ),
        (
            [('"back"', '"Near"')],
            'sensor[3].name: "Near" differs in capitals only from the name of sensor[0]; give each '
            "sensor a name of its own",
        ),
        (
            [('"back"', '"far-left"')],
            'sensor[3].name: "far-left" is not a C identifier; write a C identifier of at most 20 '
            'characters, such as "near_left"',
        ),
        (
            [('"back"', '"switch"')],
            'sensor[3].name: "switch" is a keyword of C or C++; write a C identifier of at most 20 '
            'characters, such as "near_left"',
        ),
        (
            [("span = [0, 5]", "span = [0, 12]")],
            "sensor[0].span: span [0, 12] lies outside the joint; write segments from 0 to 11",
        ),
        (
            [("span = [0, 5]", "span = [5, 0]")],
            "sensor[0].span: span [5, 0] is reversed; write [0, 5]",
        ),
        (
            [("span_m = [0.05, 0.24]", "span_m = [0.05, 0.25]")],
            "sensor[2].span_m: span [0.05, 0.25] lies outside the joint; write metres from 0 at "
            "the base to 0.24 at the tip (geometry.length)",
        ),
        (
            [("span_m = [0.05, 0.24]", "span_m = [0.1, 0.1]")],
            "sensor[2].span_m: span [0.1, 0.1] is empty; write where it begins and where it ends, "
            "in m",
        ),
        (
            [("span_m = [0.05, 0.24]", "span_m = [0.2, 0.1]")],
            "sensor[2].span_m: span [0.2, 0.1] is reversed; write [0.1, 0.2]",
        ),
        (
            [("span_m = [0.05, 0.24]", "span = [0, 3]\nspan_m = [0.05, 0.24]")],
            "sensor[2].span_m: stands beside span; remove one of them, either says it all",
        ),
        (
            [("span = [0, 5]\n", "")],
            "sensor[0].span: missing; write span = [0, 5] (the first and the last segment, counted "
            "from 0)",
        ),
        (
            [("radius = 0.031\n", "")],
            "sensor[1].radius: missing; write radius = 0.05 (the tendons' distance from the "
            "neutral axis in metres, from 1e-6 to 1000)",
        ),
        (
            [("angle = 210.0", "angle = 400.0")],
            "sensor[1].angle: 400.0 is too large; write degrees around the neutral axis from +x, "
            "counter-clockwise seen from the tip, from -360 to 360, such as angle = 180.0",
        ),
        (
            [("radius = 0.031", "raduis = 0.031")],
            "sensor[1].raduis: unknown key; did you mean radius?",
        ),
        (
            [("zero = 100", "zero = 4096")],
            "sensor[1].zero: 4096 is no count of 12 bits without sign; write a count from 0 to "
            "4095",
        ),
        (
            [("range = [3, 1000]", "range = [-3, 1000]")],
            "sensor[2].range: range [-3, 1000] exceeds 10 bits without sign; write counts from 0 "
            "to 1023",
        ),
        (
            [("zero = 512", "zero = 1")],
            "sensor[2].range: range [3, 1000] leaves out 1, the zero; write a lowest count of 1 or "
            "less and a highest of 1 or more",
        ),
        (
            [("bits = 12", "bits = 16")],
            "sensors.transducer.bits: 16 bits without sign do not fit precision = 16; write at "
            "most 15, or precision = 32",
        ),
        (
            [("bits = 12\n", "")],
            "sensors.transducer.signed: 16 bits without sign do not fit precision = 16; write "
            "bits = 15 or fewer, or precision = 32",
        ),
        (
            [("metres_per_count = -1.2e-5", "metres_per_count = 0.0")],
            "sensor[1].metres_per_count: 0.0 is too near to 0; write the length of one count in "
            "metres, from 1e-12 to 1, negative where the count falls as the sensor lengthens, such "
            "as metres_per_count = 2e-06",
        ),
        (
            [("noise = 1.0e-4", "noise = [1.0e-4, 2e-4]")],
            "sensors.transducer.noise: 2 values for 4 sensors; write one value, or one for each",
        ),
        (
            [("[sensors.transducer]", "[sensors]\nradius = 0.03\n[sensors.transducer]")],
            "sensors.radius: stands beside [[sensor]], which says it of each sensor; remove one of "
            "them",
        ),
        (
            [("[sensors.transducer]", "[sensors.v]\nradius = 0.03\n[sensors.transducer]")],
            "sensors.v: stands beside [[sensor]], which says it of each sensor; remove one of them",
        ),
    ],
)
def test_wrong_sensors_are_refused(changes, says):
    assert refusal(edited(*changes)) == says


def test_a_table_where_a_list_of_tables_belongs_is_refused():
    text = 'name = "a"\n[geometry]\nsegments = 2\nlength = 0.1\nrange_of_motion = 3.0\n[sensor]\n'
    assert refusal(text) == "sensor: is a table; write at most 16 tables, such as [[sensor]]"


def test_more_than_sixteen_sensors_are_refused():
    assert refusal(square([90] * 17)) == (
        "sensor: has 17 items; write at most 16 tables, such as [[sensor]]"
    )


@pytest.mark.parametrize(
    ("angles", "tables", "says"),
    [
        (
            (90, 270),
            "",
            "sensor: none sees axis v, for all are at 90 or 270 degrees; write an angle of "
            '0 or 180 for one, or leave "v" out of estimator.axes',
        ),
        (
            (-180, 360),
            "",
            "sensor: none sees axis u, for all are at 0 or 180 degrees; write an angle of "
            '90 or 270 for one, or leave "u" out of estimator.axes',
        ),
        (
            (30, 210, -150),
            "",
            "sensor: all are at 30 or 210 degrees, which see u and v together only; write another "
            'angle for one, such as 120, or estimator.axes = ["v"] for a joint that bends in one '
            "plane",
        ),
        (
            (90, 180),
            '[estimator]\naxes = ["v"]',
            "sensor[0].angle: at 90 degrees it sees nothing of axis v, all that estimator.axes "
            "names; remove the sensor, or name the other axis too",
        ),
    ],
)
def test_an_axis_that_no_angle_sees_is_named(angles, tables, says):
    assert refusal(square(angles, tables)) == says


def test_segments_over_which_an_axis_is_not_seen_are_named():
    text = square((90, 180)).replace("[0, 11]\nangle = 180", "[0, 8]\nangle = 180")
    assert refusal(text) == (
        "sensor: none sees axis v over segments 9 to 11; let one that does, such as at 0 or 180 "
        "degrees, cover them"
    )
    text = square((45, 135)).replace("[0, 11]\nangle = 135", "[1, 11]\nangle = 135")
    assert refusal(text) == (
        "sensor: all over segment 0 are at 45 degrees, which see u and v together only; write "
        'another angle for one, such as 135, or estimator.axes = ["v"] for a joint that bends in '
        "one plane"
    )


# ---- lists and metres in [sensors] -----------------------------------------------------------


def lists(sensors, transducer="metres_per_count = 2e-6", tables=""):
    return (
        'name = "lists"\n[geometry]\nsegments = 12\nlength = 0.24\nrange_of_motion = 3.0\n'
        f"[sensors]\n{sensors}\n[sensors.transducer]\n{transducer}\n{tables}"
    )


def test_a_list_gives_one_value_a_sensor_of_each_axis_or_of_both():
    text = lists(
        "count = 2\nradius = [0.03, 0.04]",
        "metres_per_count = [1e-6, 2e-6, 3e-6, 4e-6]\nrange = [[-20000, 20000], [-30000, 30000]]\n"
        "noise = 1e-5",
    )
    joint = parse_joint(text, "lists.toml")
    assert [one.radius for one in joint.sensors] == [0.03, 0.04, 0.03, 0.04]
    assert [one.metres_per_count for one in joint.sensors] == [1e-6, 2e-6, 3e-6, 4e-6]
    assert joint.sensors[3].range == (-30000, 30000)
    assert (joint.u.radius, joint.u.transducer) == (None, None)


def test_values_that_are_alike_stay_the_sets():
    joint = parse_joint(lists("count = 2\nradius = [0.03, 0.03]"), "lists.toml")
    assert joint.u.radius == 0.03
    assert joint.u.transducer.metres_per_count == 2e-6


def test_lists_of_the_wrong_length_are_refused():
    assert refusal(lists("count = 3\nradius = [0.03, 0.04]")) == (
        "sensors.radius: 2 values, but axis u has 3 sensors; write one value, or 3, or 6 for all "
        "sensors, u's first"
    )
    text = lists("count = 3\nradius = 0.03", tables="[sensors.v]\nradius = [0.1, 0.2]\ncount = 1")
    assert refusal(text) == (
        "sensors.v.radius: 2 values, but axis v has 1 sensor; write one value, or 1"
    )
    text = lists("count = 3\nradius = 0.03", "metres_per_count = 2e-6\nbits = [16, 14, 17]")
    assert refusal(text) == (
        "sensors.transducer.bits[2]: 17 bits do not fit precision = 16; write at most 16, or "
        "precision = 32"
    )
    text = lists("count = 3\nradius = 0.03", "metres_per_count = 2e-6\nnoise = [1e-5, -1e-5]")
    assert refusal(text) == (
        "sensors.transducer.noise[1]: -1e-05 is too small; write one standard deviation of the "
        "length in metres, 0 or from 1e-12 to 1000, such as noise = 2e-05"
    )


def test_spans_in_metres_are_spans_in_segments_where_they_end_on_borders():
    in_metres = lists("spans_m = [[0.0, 0.1], [0.06, 0.18], [0.14, 0.24]]\nradius = 0.05")
    in_segments = lists("spans = [[0, 4], [3, 8], [7, 11]]\nradius = 0.05")
    assert parse_joint(in_metres, "lists.toml") == parse_joint(in_segments, "lists.toml")


def test_spans_in_metres_may_cover_parts_of_segments():
    joint = parse_joint(lists("spans_m = [[0.0, 0.13], [0.1, 0.24]]\nradius = 0.05"), "lists.toml")
    assert [(one.start, one.end) for one in joint.sensors[:2]] == [(0, 6.5), (5, 12)]


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        (
            "spans_m = [[0.0, 0.1], [0.15, 0.24]]",
            "sensors.spans_m: no span covers segments 5 to 6; let the spans cover segments 0 to 11 "
            "without a gap",
        ),
        (
            "spans_m = [[0.0, 0.3]]",
            "sensors.spans_m[0]: span [0.0, 0.3] lies outside the joint; write metres from 0 at "
            "the base to 0.24 at the tip (geometry.length)",
        ),
        (
            "spans_m = [[-0.1, 0.24]]",
            "sensors.spans_m[0][0]: -0.1 is too small; write 1 to 8 spans [from, to] in metres "
            "along the joint, such as spans_m = [[0.0, 0.1], [0.06, 0.24]]",
        ),
        (
            "spans_m = [[0.0, 0.24]]\nspans = [[0, 11]]",
            "sensors.spans_m: stands beside spans; remove one of them, either says it all",
        ),
        (
            'spans_m = [[0.0, 0.24]]\nplacement = "single"',
            "sensors.spans_m: stands beside placement; remove one of them, spans alone say it all",
        ),
    ],
)
def test_wrong_spans_in_metres_are_refused(keys, says):
    assert refusal(lists(f"{keys}\nradius = 0.05")) == says


# ---- geometry and axes -----------------------------------------------------------------------


SENSORS = "[sensors]\nradius = 0.05\n[sensors.transducer]\nmetres_per_count = 2e-6"


def geometry(keys, tables=SENSORS):
    return f'name = "plain"\n[geometry]\nsegments = 12\nlength = 0.24\n{keys}\n{tables}'


def test_the_range_of_motion_may_be_that_of_the_whole_joint():
    total = parse_joint(geometry("total_range_of_motion = 36.0"), "plain.toml")
    each = parse_joint(geometry("range_of_motion = 3.0"), "plain.toml")
    assert total == each


def test_sections_elongate_by_themselves():
    keys = "range_of_motion = 3.0\nsections = [4, 8]\nelongation = [-0.01, 0.3]"
    joint = parse_joint(geometry(keys), "plain.toml")
    assert joint.geometry.sections == (4, 8)
    assert joint.axes == ("u", "v", "h")
    assert joint.own("u") == slice(0, 6)


def test_loads_state_an_elongation_too():
    text = geometry("range_of_motion = 3.0", f"{SENSORS}\n[loads]\nelongation = [0.0, 0.03]")
    joint = parse_joint(text, "plain.toml")
    assert joint.geometry.elongation == (0.0, 0.03)
    assert joint.axes == ("u", "v", "h")


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        (
            "",
            "geometry.range_of_motion: missing; write range_of_motion = 3.0 (degrees per segment "
            "and axis, from 1e-06 to 90)",
        ),
        (
            "range_of_motion = 3.0\ntotal_range_of_motion = 36.0",
            "geometry.total_range_of_motion: stands beside range_of_motion; remove one of them",
        ),
        (
            "total_range_of_motion = 1100.0",
            "geometry.total_range_of_motion: 1100 degrees are more than 90 for each of 12 "
            "segments; write at most 1080, or more segments",
        ),
        (
            "range_of_motion = 3.0\nelongation = [0.1, 0.0]",
            "geometry.elongation: [0.1, 0.0] is reversed; write the lowest share of the length "
            "first, such as elongation = [0.0, 0.05]",
        ),
        (
            "range_of_motion = 3.0\nelongation = [0.1, 0.1]",
            "geometry.elongation: [0.1, 0.1] holds one value only; write the lowest share of the "
            "length first, such as elongation = [0.0, 0.05]",
        ),
        (
            "range_of_motion = 3.0\nelongation = [0.0, 5.0]",
            "geometry.elongation[1]: 5.0 is too large; write the lowest and the highest share of "
            "the length, from -0.5 to 2, such as elongation = [0.0, 0.05]",
        ),
        (
            "range_of_motion = 3.0\nelongation = [0.0, 0.05]\nsections = [6, 5]",
            "geometry.sections: [6, 5] are 11 segments in all; let them add up to segments = 12",
        ),
        (
            "range_of_motion = 3.0\nsections = [6, 6]",
            "geometry.sections: says which parts elongate by themselves, but the file states no "
            "elongation; write elongation = [0.0, 0.05] too, or remove sections",
        ),
    ],
)
def test_wrong_geometries_are_refused(keys, says):
    assert refusal(geometry(keys)) == says


@pytest.mark.parametrize(
    ("axes", "says"),
    [
        (
            '["u", "v", "h"]',
            'geometry.elongation: missing, but estimator.axes has "h"; write '
            "elongation = [0.0, 0.05] (the lowest and the highest share of the length)",
        ),
        ('["h"]', 'estimator.axes: ["h"] leaves out both bending axes; add "u" or "v" to it'),
        ('["u", "u"]', 'estimator.axes[1]: "u" stands there twice; write each axis once'),
        (
            "[]",
            'estimator.axes: [] has 0 items; write one or more of "u", "v", "h", such as '
            'axes = ["u", "v"]',
        ),
        (
            '["w"]',
            'estimator.axes[0]: "w" is unknown; write one or more of "u", "v", "h", such as '
            'axes = ["u", "v"]',
        ),
    ],
)
def test_wrong_axes_are_refused(axes, says):
    assert refusal(joint_text(tables=f"[estimator]\naxes = {axes}")) == says


def test_a_set_of_an_axis_that_is_left_out_is_refused():
    text = joint_text(tables='[estimator]\naxes = ["u"]', transducer="[sensors.v]\ncount = 2")
    assert refusal(text) == (
        'sensors.v: stands there, but estimator.axes leaves "v" out; remove one of them'
    )


def test_the_noise_that_noise_aware_weights_need_is_missed_where_it_belongs():
    text = edited(("noise = 1.0e-4\n", ""), ('"near"', '"near"\nnoise = 1e-4')) + (
        '[estimator]\nmethod = "noise-aware"\n'
    )
    assert refusal(text) == (
        'sensor[1].noise: missing, but method = "noise-aware" weighs by it; write noise = 2e-05 '
        '(m, one standard deviation), or method = "wam"'
    )
