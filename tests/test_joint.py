"""What a joint file may hold, and what is said of one that is wrong."""

import math
import re
import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccgen.errors import InputError
from ccgen.joint import (
    CASES,
    METHODS,
    AxisSensors,
    Can,
    Joint,
    ShapeSettings,
    Transducer,
)
from ccgen.joint.file import parse_joint, read_joint
from ccgen.joint.layouts import LAYOUTS
from ccgen.joint.names import LONGEST_NAME, name_problem
from ccgen.joint.places import has_own_table, sensor_key
from ccgen.joint.sensor_tables import AxisTable
from ccgen.joint.tables import EstimatorTable, JointTable, ShapesTable

EXAMPLES = Path(__file__).parent.parent / "examples"

SMALLEST = """\
name = "shoulder"

[geometry]
segments = 12
length = 0.24
range_of_motion = 3.0

[sensors]
radius = 0.05

[sensors.transducer]
metres_per_count = 2.0e-6
"""


def joint_with(old: str = "", new: str = "", end: str = "") -> Joint:
    """The smallest joint with a part of its file replaced, and lines added at its end."""
    assert old in SMALLEST
    return parse_joint(SMALLEST.replace(old, new, 1) + end, "shoulder.toml")


def sensors_with(lines: str) -> Joint:
    return joint_with("radius = 0.05\n", f"radius = 0.05\n{lines}\n")


def message(error: pytest.ExceptionInfo[InputError]) -> str:
    text = str(error.value)
    assert "\n" not in text
    return text


def refusal(old: str = "", new: str = "", end: str = "") -> str:
    with pytest.raises(InputError) as error:
        joint_with(old, new, end)
    return message(error).removeprefix("shoulder.toml: ")


def refusal_of_sensors(lines: str) -> str:
    return refusal("radius = 0.05\n", f"radius = 0.05\n{lines}\n")


def test_what_the_file_leaves_out_has_its_default():
    joint = joint_with()
    assert (joint.name, joint.source) == ("shoulder", "shoulder.toml")
    assert (joint.geometry.segments, joint.geometry.length) == (12, 0.24)
    assert joint.u == joint.v == joint.axis("u")
    assert (joint.u.placement, joint.u.spans) == ("heuristic", ((0, 4), (3, 8), (7, 11)))
    assert joint.u.transducer == Transducer(16, 2e-6, None, None)
    assert joint.shapes == ShapeSettings(CASES, fit_samples=30, score_samples=10)
    assert (joint.method, joint.precision) == ("wam", 16)
    assert joint.can == Can(0x300, extended=False, fd=False, bitrate=1_000_000, cycle_ms=10)


def test_angles_are_degrees_in_the_file_and_radians_in_the_joint():
    assert joint_with().geometry.range_of_motion == math.radians(3.0)


def test_a_segments_length_is_its_share():
    assert joint_with().geometry.segment_length == pytest.approx(0.02, rel=1e-15)


def test_whole_numbers_are_good_lengths():
    joint = joint_with("length = 0.24", "length = 2")
    assert joint.geometry.length == 2.0
    assert isinstance(joint.geometry.length, float)


def test_the_same_file_elsewhere_is_the_same_joint():
    assert parse_joint(SMALLEST, "a.toml") == parse_joint(SMALLEST, "b.toml")


def test_an_unknown_axis_is_refused():
    with pytest.raises(ValueError, match="unknown axis 'w'; known: u, v"):
        joint_with().axis("w")


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.toml")), ids=lambda file: file.name)
def test_every_example_is_a_joint(file):
    assert read_joint(file).name == file.stem


def test_the_tables_know_the_names_that_the_joint_declares():
    def known(table: type, key: str) -> tuple[str, ...]:
        text = str(table.model_fields[key].annotation)
        return tuple(re.findall(r"'([^']+)'", text))

    assert known(ShapesTable, "cases") == CASES
    assert known(EstimatorTable, "method") == METHODS
    assert known(AxisTable, "placement") == LAYOUTS


def test_every_key_says_what_would_be_right():
    def keys(table: type) -> list:
        fields = list(table.model_fields.values())
        kinds = [kind for f in fields for kind in (f.annotation, *get_args(f.annotation))]
        inner = [kind for kind in kinds if hasattr(kind, "model_fields")]
        return fields + [field for each in inner for field in keys(each)]

    assert all(field.description and field.examples for field in keys(JointTable))


# ---- sensors ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lines", "spans"),
    [
        ('placement = "single"', ((0, 11),)),
        ('placement = "single"\ncount = 1', ((0, 11),)),
        ('placement = "end-to-end"\ncount = 2', ((0, 5), (6, 11))),
        ("count = 2", ((0, 6), (5, 11))),
        ("spans = [[0, 7], [6, 11]]", ((0, 7), (6, 11))),
        ("spans = [[0, 7], [6, 11]]\ncount = 2", ((0, 7), (6, 11))),
    ],
)
def test_spans_come_from_a_placement_or_a_list(lines, spans):
    assert sensors_with(lines).u.spans == spans


def test_one_axis_replaces_single_keys():
    joint = sensors_with(
        "count = 2\n[sensors.v]\ncount = 4\nradius = 0.04\n"
        "[sensors.v.transducer]\nnoise = 1e-5\nrange = [-10, 20]"
    )
    assert (len(joint.u.spans), joint.u.radius) == (2, 0.05)
    assert joint.u.transducer == Transducer(16, 2e-6, None, None)
    assert (len(joint.v.spans), joint.v.radius) == (4, 0.04)
    assert [has_own_table(joint, axis) for axis in "uv"] == [False, True]
    keys = [[sensor_key(joint, sensor, key) for key in ("noise", "bits")] for sensor in (1, 2)]
    assert keys == [
        ["sensors.transducer.noise", "sensors.transducer.bits"],
        ["sensors.v.transducer.noise", "sensors.transducer.bits"],
    ]
    assert joint.v.transducer == Transducer(16, 2e-6, 1e-5, (-10, 20))


@pytest.mark.parametrize(
    ("common", "own", "spans"),
    [
        ("spans = [[0, 11]]", 'placement = "end-to-end"\ncount = 2', ((0, 5), (6, 11))),
        ("count = 3", 'placement = "single"', ((0, 11),)),
        ("count = 3", "spans = [[0, 6], [5, 11]]", ((0, 6), (5, 11))),
        ('placement = "end-to-end"\ncount = 3', "count = 1", ((0, 11),)),
        ("count = 2", 'placement = "end-to-end"', ((0, 5), (6, 11))),
    ],
)
def test_an_axis_own_placement_replaces_the_common_one(common, own, spans):
    joint = sensors_with(f"{common}\n[sensors.v]\n{own}")
    assert joint.v.spans == spans
    assert joint.u == sensors_with(common).u


def test_both_axes_may_bring_everything_themselves():
    text = SMALLEST[: SMALLEST.index("[sensors]")] + "".join(
        f"[sensors.{axis}]\nradius = 1\n[sensors.{axis}.transducer]\nmetres_per_count = 1e-4\n"
        for axis in "uv"
    )
    joint = parse_joint(text, "x.toml")
    assert isinstance(joint.u, AxisSensors)
    assert joint.u == joint.v


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (
            "spans = [[0, 4], [8, 3], [7, 11]]",
            "sensors.spans[1]: span [8, 3] is reversed; write [3, 8]",
        ),
        (
            "spans = [[0, 4], [4, 12]]",
            "sensors.spans[1]: span [4, 12] lies outside the joint; write segments from 0 to 11",
        ),
        (
            "spans = [[-1, 11]]",
            "sensors.spans[0]: span [-1, 11] lies outside the joint; write segments from 0 to 11",
        ),
        (
            "spans = [[1, 3], [6, 6], [8, 11]]",
            "sensors.spans: no span covers segments 0, 4 to 5, 7; "
            "let the spans cover segments 0 to 11 without a gap",
        ),
        (
            "spans = [[0, 4], [6, 11]]",
            "sensors.spans: no span covers segment 5; "
            "let the spans cover segments 0 to 11 without a gap",
        ),
        (
            "spans = [[0, 4], [8]]",
            "sensors.spans[1]: [8] has 1 item; write 1 to 8 spans [first, last] of segments "
            "counted from 0, such as spans = [[0, 4], [3, 8], [7, 11]]",
        ),
        (
            "spans = [[0, 11], [0, 1.5]]",
            "sensors.spans[1][1]: 1.5 is a decimal number; write 1 to 8 spans [first, last] of "
            "segments counted from 0, such as spans = [[0, 4], [3, 8], [7, 11]]",
        ),
        (
            f"spans = {[[0, 11]] * 9}",
            "sensors.spans: [[0, 11], [0, 11], [0, 11], [0, 11], ... has 9 items; write 1 to 8 "
            "spans [first, last] of segments counted from 0, "
            "such as spans = [[0, 4], [3, 8], [7, 11]]",
        ),
        (
            'spans = [[0, 11]]\nplacement = "single"',
            "sensors.spans: stands beside placement; remove one of them, spans alone say it all",
        ),
        (
            "spans = [[0, 11]]\ncount = 2",
            "sensors.count: 2 contradicts the spans listed; remove it, or write count = 1",
        ),
        (
            "spans = [[0, 11]]\n[sensors.v]\ncount = 2",
            "sensors.v.count: 2 contradicts the spans listed; remove it, or write count = 1",
        ),
        (
            "[sensors.u]\nspans = [[3, 1]]",
            "sensors.u.spans[0]: span [3, 1] is reversed; write [1, 3]",
        ),
        (
            'placement = "end-to-end"',
            "sensors.count: missing; write count = 3 (the number of sensors of an axis, from 1 "
            "to 8)",
        ),
        (
            'spans = [[0, 11]]\n[sensors.u]\nplacement = "heuristic"',
            "sensors.u.count: missing; write count = 3 (the number of sensors of an axis, from 1 "
            "to 8)",
        ),
        (
            'placement = "single"\ncount = 3',
            'sensors.count: 3 sensors with placement "single"; remove it, or write '
            'placement = "heuristic"',
        ),
        (
            'placement = "heuristc"\ncount = 3',
            'sensors.placement: "heuristc" is unknown; did you mean "heuristic"?',
        ),
        (
            "count = 9",
            "sensors.count: 9 is too large; write the number of sensors of an axis, from 1 to 8, "
            "such as count = 3",
        ),
        (
            "u = 3",
            "sensors.u: 3 is an integer; write a table of its own, such as [sensors.u]",
        ),
    ],
)
def test_wrong_sensors_are_refused(lines, says):
    assert refusal_of_sensors(lines) == says


def test_more_sensors_than_segments_are_refused():
    assert (
        refusal("segments = 12", "segments = 2")
        == "sensors.count: 3 sensors do not fit 2 segments; write a count from 1 to 2"
    )


# ---- transducers -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (
            "bits = 17",
            "sensors.transducer.bits: 17 bits do not fit precision = 16; write at most 16, "
            "or precision = 32",
        ),
        (
            "bits = 1",
            "sensors.transducer.bits: 1 is too small; write the width of a count, from 2 to 16 "
            "bits (32 with precision = 32), such as bits = 16",
        ),
        (
            "range = [-32768, 100]",
            "sensors.transducer.range: range [-32768, 100] exceeds 16 bits, whose lowest count "
            "means no reading; write counts from -32767 to 32767",
        ),
        (
            "bits = 8\nrange = [0, 128]",
            "sensors.transducer.range: range [0, 128] exceeds 8 bits, whose lowest count "
            "means no reading; write counts from -127 to 127",
        ),
        (
            "range = [5, 100]",
            "sensors.transducer.range: range [5, 100] leaves out 0, the count of the straight "
            "joint; write a lowest count of 0 or less and a highest of 0 or more, or state the "
            "zero",
        ),
        (
            "range = [100, -100]",
            "sensors.transducer.range: range [100, -100] is reversed; write [-100, 100]",
        ),
        (
            "range = [0, 0]",
            "sensors.transducer.range: range [0, 0] holds one count only; write the lowest and "
            "the highest count",
        ),
        (
            "range = [-1, 0, 1]",
            "sensors.transducer.range: [-1, 0, 1] has 3 items; write the lowest and the highest "
            "count, such as range = [-20000, 20000]",
        ),
        (
            "noise = -1e-5",
            "sensors.transducer.noise: -1e-05 is too small; write one standard deviation of the "
            "length in metres, 0 or from 1e-12 to 1000, such as noise = 2e-05",
        ),
        (
            '[estimator]\nmethod = "noise-aware"',
            'sensors.transducer.noise: missing, but method = "noise-aware" weighs by it; write '
            'noise = 2e-05 (m, one standard deviation), or method = "wam"',
        ),
        (
            '[sensors.u.transducer]\nnoise = 0\n[estimator]\nmethod = "noise-aware"',
            'sensors.v.transducer.noise: missing, but method = "noise-aware" weighs by it; write '
            'noise = 2e-05 (m, one standard deviation), or method = "wam"',
        ),
        (
            "[sensors.u.transducer]\nbits = 20",
            "sensors.u.transducer.bits: 20 bits do not fit precision = 16; write at most 16, "
            "or precision = 32",
        ),
    ],
)
def test_wrong_transducers_are_refused(lines, says):
    assert refusal(end=lines) == says


def test_precision_32_takes_32_bit_counts():
    joint = joint_with(end="bits = 32\nrange = [-2_147_483_647, 1]\n[fixed_point]\nprecision = 32")
    assert joint.u.transducer.range == (-(2**31) + 1, 1)


def test_missing_radius_and_count_length_are_named():
    assert refusal("radius = 0.05") == (
        "sensors.radius: missing; write radius = 0.05 "
        "(the tendons' distance from the neutral axis in metres, from 1e-6 to 1000)"
    )
    assert refusal("metres_per_count = 2.0e-6") == (
        "sensors.transducer.metres_per_count: missing; write metres_per_count = 2e-06 "
        "(the length of one count in metres, from 1e-12 to 1, negative where the count falls as "
        "the sensor lengthens)"
    )


# ---- single values ---------------------------------------------------------------------------

_SEGMENTS = "write a whole number from 1 to 64, such as segments = 12"
_LENGTH = "write the joint's length in metres, from 1e-6 to 1000, such as length = 0.24"
_RANGE = "write degrees per segment and axis, from 1e-06 to 90, such as range_of_motion = 3.0"


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("segments", "0", f"0 is too small; {_SEGMENTS}"),
        ("segments", "65", f"65 is too large; {_SEGMENTS}"),
        ("segments", "12.0", f"12.0 is a decimal number; {_SEGMENTS}"),
        ("segments", "true", f"true is a boolean; {_SEGMENTS}"),
        ("segments", '"12"', f'"12" is a string; {_SEGMENTS}'),
        ("segments", "[12]", f"[12] is a list; {_SEGMENTS}"),
        ("segments", "{ n = 1 }", f"is a table; {_SEGMENTS}"),
        ("segments", "1979-05-27", f"1979-05-27 is a date or time; {_SEGMENTS}"),
        ("length", "0", f"0 is too small; {_LENGTH}"),
        ("length", "-0.24", f"-0.24 is too small; {_LENGTH}"),
        ("length", "nan", f"nan is not finite; {_LENGTH}"),
        ("length", "inf", f"inf is not finite; {_LENGTH}"),
        ("length", "true", f"true is a boolean; {_LENGTH}"),
        ("length", "1" + 400 * "0", f"1{35 * '0'} ... is too large; {_LENGTH}"),
        ("range_of_motion", "0.0", f"0.0 is too small; {_RANGE}"),
        ("range_of_motion", "90.1", f"90.1 is too large; {_RANGE}"),
    ],
)
def test_wrong_values_are_refused(key, value, says):
    line = next(line for line in SMALLEST.splitlines() if line.startswith(key))
    assert refusal(line, f"{key} = {value}") == f"geometry.{key}: {says}"


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (
            "[shapes]\ncases = []",
            "shapes.cases: [] leaves no shapes to fit to; name a load case there, or state [loads] "
            "or [[recordings]]",
        ),
        (
            "[shapes]\nweight = { load = 1.0 }",
            "shapes.weight.load: unknown key; did you mean loads?",
        ),
        (
            "[shapes]\nweight = { loads = 0.5 }",
            "shapes.weight.loads: 0.5 for a source that is not there; remove it, or add [loads]",
        ),
        (
            "[shapes]\nweight = { cases = 0.0 }",
            "shapes.weight: is 0 for every source; write a weight above 0 for one of them",
        ),
        (
            '[shapes]\ncases = ["uniform", "sshape"]',
            'shapes.cases[1]: "sshape" is unknown; did you mean "s-shape"?',
        ),
        (
            '[shapes]\ncases = ["uniform", "uniform"]',
            'shapes.cases[1]: "uniform" stands there twice; write each case once',
        ),
        (
            "[shapes]\nfit_samples = 0",
            "shapes.fit_samples: 0 is too small; write amplitudes per load case, from 1 to 1000, "
            "such as fit_samples = 30",
        ),
        (
            '[estimator]\nmethod = "magic"',
            'estimator.method: "magic" is unknown; write "direct", "equal", "wam" or '
            '"noise-aware", such as method = "wam"',
        ),
        (
            "[fixed_point]\nprecision = 24",
            "fixed_point.precision: 24 is unknown; write 16 or 32, such as precision = 16",
        ),
        (
            "[fixed_point]\nprecision = 16.0",
            "fixed_point.precision: 16.0 is a decimal number; write 16 or 32, "
            "such as precision = 16",
        ),
        (
            "[can]\nfd = 1",
            "can.fd: 1 is an integer; write true or false, such as fd = false",
        ),
        (
            "[can]\nbitrate = 5_000_000",
            "can.bitrate: 5000000 is too large; write bits per second of the arbitration, from "
            "10_000 to 1_000_000, such as bitrate = 1000000",
        ),
        (
            "[can]\ncycle_ms = 0",
            "can.cycle_ms: 0 is too small; write milliseconds, from 1 to 1000, "
            "such as cycle_ms = 10",
        ),
        (
            '[can]\npublish = ["angels"]',
            'can.publish[0]: "angels" is unknown; did you mean "angles"?',
        ),
        (
            '[can]\npublish = ["tip", "status", "tip"]',
            'can.publish: names "tip" twice; write each kind once',
        ),
        (
            "[can]\nrate_switch = true",
            "can.rate_switch: true, but classic CAN has one bit rate; leave it out, or fd = true",
        ),
        (
            "[can]\nbase_id = 0x7f5",
            "can.base_id: 14 frames from 0x7f5 on exceed 11 bits; write at most 0x7f2, "
            "or extended = true",
        ),
        (
            "[can]\nbase_id = 0x1fffffff\nextended = true",
            "can.base_id: 14 frames from 0x1fffffff on exceed 29 bits; write at most 0x1ffffff2",
        ),
        (
            "[can]\nfd = true\nbase_id = 0x7fd",
            "can.base_id: 6 frames from 0x7fd on exceed 11 bits; write at most 0x7fa, "
            "or extended = true",
        ),
        ("[[can]]", "can: [{}] is a list; write a table, such as [can]"),
    ],
)
def test_wrong_tables_are_refused(lines, says):
    assert refusal(end=lines) == says


@pytest.mark.parametrize("base_id", ["0x7f2", "0"])
def test_identifiers_may_reach_the_last_one(base_id):
    assert joint_with(end=f"[can]\nbase_id = {base_id}").can.base_id == int(base_id, 0)


# ---- keys ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("radius", "radios", "sensors.radios: unknown key; did you mean radius?"),
        ("[geometry]", "[geomtry]", "geomtry: unknown key; did you mean geometry?"),
        ("radius", "segments", "sensors.segments: unknown key here; write it in [geometry]"),
        (
            "radius",
            "colour",
            "sensors.colour: unknown key; the known ones are placement, spans, spans_m, count, "
            "radius, transducer, u, v",
        ),
        (
            "radius",
            '"a\\nb"',
            'sensors."a\\nb": unknown key; the known ones are placement, spans, spans_m, count, '
            "radius, transducer, u, v",
        ),
    ],
)
def test_unknown_keys_suggest_known_ones(old, new, says):
    assert refusal(old, new) == says


def test_missing_keys_are_named():
    assert refusal("segments = 12") == (
        "geometry.segments: missing; write segments = 12 (a whole number from 1 to 64)"
    )
    assert refusal('name = "shoulder"') == (
        'name: missing; write name = "shoulder" (a C identifier of at most 20 characters)'
    )


# ---- names -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a", "shoulder", "Shoulder_2", "x" * LONGEST_NAME, "format"])
def test_plain_identifiers_are_names(name):
    assert name_problem(name) is None


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("", "is empty"),
        ("x" * 21, "has 21 characters, 20 at most fit the DBC"),
        ("2nd", "is not a C identifier"),
        ('a"b', "is not a C identifier"),
        ("a b", "is not a C identifier"),
        ("a\n", "is not a C identifier"),
        ("schulter-ä", "is not a C identifier"),
        ("é", "is not a C identifier"),
        ("_a", "is reserved in C and C++ (leading or double underscore)"),
        ("a__b", "is reserved in C and C++ (leading or double underscore)"),
        ("int", "is a keyword of C or C++"),
        ("restrict", "is a keyword of C or C++"),
        ("typeof", "is a keyword of C or C++"),
        ("class", "is a keyword of C or C++"),
        ("co_await", "is a keyword of C or C++"),
        ("not_eq", "is a keyword of C or C++"),
        ("uint8", "collides with the type uint8_t of the C library"),
        ("size", "collides with the type size_t of the C library"),
        ("string", "collides with the header string.h of the C library"),
        ("ccgen_joint", "collides with the names of the runtime, its ports or POSIX threads"),
        ("main", "collides with a file or target of the exported folder"),
        ("port", "collides with a file or target of the exported folder"),
    ],
)
def test_names_that_c_cannot_take_are_refused(name, problem):
    assert name_problem(name) == problem


def test_a_wrong_name_is_shown_in_one_line():
    assert refusal('"shoulder"', '"a\\"\\n"') == (
        'name: "a\\"\\n" is not a C identifier; '
        'write a C identifier of at most 20 characters, such as "shoulder"'
    )


# ---- files -----------------------------------------------------------------------------------


WORKING = "`ccgen init NAME` writes one that works"


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", f"is empty; {WORKING}"),
        (b"# only a comment\n", f"is empty; {WORKING}"),
        (b'name = "a"\n\n# \xff\n', "line 3: byte 0xff is not UTF-8; save the file as UTF-8 text"),
        (b"a = " + 5000 * b"[", f"is nested too deeply; {WORKING}"),
        (bytes(1_000_001), f"more than 1000000 bytes are no joint file; {WORKING}"),
    ],
)
def test_files_that_are_no_joint_are_refused(tmp_path, data, says):
    assert refusal_of_file(tmp_path / "shoulder.toml", data) == says


@pytest.mark.parametrize(
    ("data", "place"),
    [
        (b'name = "a"\n[geometry\n', "line 2, column 10"),
        (b'name = "a"\nname = "b"\nlength = 1', "line 2, column 11"),
        (b'name = "a"\nspans = [[0, 4], [3', "line 2 (the last)"),
        (b'name = "a"\nlength = ' + 5000 * b"1", "line 2 (the last)"),
    ],
)
def test_wrong_syntax_is_refused_by_its_line(tmp_path, data, place):
    says = refusal_of_file(tmp_path / "shoulder.toml", data)
    assert re.fullmatch(rf"{re.escape(place)}: [a-z].+; write TOML, such as segments = 12", says)


def refusal_of_file(file: Path, data: bytes) -> str:
    file.write_bytes(data)
    with pytest.raises(InputError) as error:
        read_joint(file)
    return message(error).removeprefix(f"{file}: ")


def test_missing_files_and_folders_are_refused(tmp_path):
    with pytest.raises(InputError) as error:
        read_joint(tmp_path / "shoulder.toml")
    assert message(error) == (
        f"{tmp_path}/shoulder.toml: no such file; `ccgen init NAME` writes one that works"
    )
    with pytest.raises(InputError) as error:
        read_joint(tmp_path)
    assert message(error) == f"{tmp_path}: is a directory; name a joint file in it"


def test_a_byte_order_mark_is_no_error(tmp_path):
    file = tmp_path / "shoulder.toml"
    file.write_bytes(b"\xef\xbb\xbf" + SMALLEST.replace("\n", "\r\n").encode())
    assert read_joint(file) == joint_with()


@settings(max_examples=200)
@given(st.integers(0, len(SMALLEST)), st.text(max_size=4), st.integers(0, 10))
def test_damaged_text_is_a_joint_or_one_line(place, inserted, removed):
    text = SMALLEST[:place] + inserted + SMALLEST[place + removed :]
    try:
        joint, said = parse_joint(text, "damaged.toml"), ""
    except InputError as error:
        joint, said = parse_joint(SMALLEST, "shoulder.toml"), str(error)
    assert re.fullmatch(r"(damaged\.toml: [^\n\r]+)?", said)
    assert name_problem(joint.name) is None
    covered = {i for a, b in joint.u.spans for i in range(a, b + 1)}
    assert covered == set(range(joint.geometry.segments))


def test_importing_the_specification_is_cheap():
    program = "import sys, ccgen.joint; print({'pydantic', 'numpy'} & set(sys.modules))"
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert run.stdout == "set()\n"
