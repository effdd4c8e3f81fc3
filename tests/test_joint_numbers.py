"""Numbers at the ends of what a joint file may hold: they work, or one line says what would."""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text

import ccgen
from ccgen.errors import ArgumentError, FormatError, InputError, ReachError
from ccgen.joint import CASES
from ccgen.joint.units import unit_doubts
from ccgen.placement.exhaustive import covering
from ccgen.placement.problem import Problem, as_spans
from ccgen.placement.search import search
from ccgen.shapes.cases import shape_library, single_shape

EXAMPLES = Path(__file__).parent.parent / "examples"
SMALLEST = "5e-324"
HUGE = "1.7976931348623157e308"

LOADS = """\
[loads]
samples = 20
stiffness = 0.4
actuation = [-20.0, 20.0]
"""


def joint(**changes):
    return ccgen.parse(joint_text(**changes))


def ccgen_run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "ccgen", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )


def replaced(text, key, value):
    """The text with a key's value changed, or the key added to its table."""
    table, _, name = key.rpartition(".")
    lines = text.splitlines()
    start = lines.index(f"[{table}]") + 1
    end = next((i for i in range(start, len(lines)) if lines[i].startswith("[")), len(lines))
    own = [line for line in lines[start:end] if not line.startswith(f"{name} =")]
    return "\n".join([*lines[:start], *own, f"{name} = {value}", *lines[end:]])


TINY = [
    ("geometry.length", SMALLEST, "is too small"),
    ("geometry.range_of_motion", SMALLEST, "is too small"),
    ("geometry.range_of_motion", "1e-323", "is too small"),
    ("geometry.elongation", f"[0.0, {SMALLEST}]", "is narrower than 1e-06"),
    ("geometry.elongation", "[0.1, 0.10000000000000002]", "is narrower than 1e-06"),
    ("sensors.radius", SMALLEST, "is too small"),
    ("sensors.transducer.metres_per_count", SMALLEST, "is too near to 0"),
    ("sensors.transducer.metres_per_count", f"-{SMALLEST}", "is too near to 0"),
    ("sensors.transducer.noise", SMALLEST, "is too near to 0"),
    ("sensors.transducer.gain_tolerance", SMALLEST, "is too near to 0"),
    ("shapes.weight", f"{{ loads = {SMALLEST} }}", "is too near to 0"),
    ("loads.stiffness", SMALLEST, "is too small"),
    ("loads.stiffness_profile", f"[{SMALLEST}]", "is too small"),
    ("loads.stiffness_tolerance", SMALLEST, "is too near to 0"),
    ("loads.elongation", f"[0.0, {SMALLEST}]", "is too near to 0"),
    ("estimator.false_alarms", SMALLEST, "is too small"),
]

TABLES = f"[shapes]\n[estimator]\n{LOADS}"


@pytest.mark.parametrize(("key", "value", "what"), TINY)
def test_a_number_too_near_to_zero_is_refused_by_its_key_with_the_least_one(key, value, what):
    text = replaced(joint_text(tables=TABLES), key, value)
    with pytest.raises(InputError, match=rf"^joint\.toml: {key}.*{what}; write ") as refused:
        ccgen.parse(text)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "key",
    [
        "geometry.length",
        "geometry.range_of_motion",
        "geometry.total_range_of_motion",
        "sensors.radius",
        "sensors.transducer.metres_per_count",
        "sensors.transducer.noise",
        "sensors.transducer.gain_tolerance",
        "loads.stiffness",
        "loads.stiffness_tolerance",
        "loads.mass",
        "loads.mounting",
        "loads.contact_from",
        "estimator.false_alarms",
    ],
)
@pytest.mark.parametrize("value", [HUGE, f"-{HUGE}", "inf", "nan", str(10**400)])
def test_a_number_that_is_huge_or_none_is_refused_by_its_key(key, value):
    text = replaced(joint_text(tables=TABLES), key, value)
    with pytest.raises(InputError, match=rf"^joint\.toml: {key}: .*; write ") as refused:
        ccgen.parse(text)
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 300


def test_a_total_range_of_motion_too_small_for_its_segments_is_refused():
    text = joint_text().replace("range_of_motion = 3.0", "total_range_of_motion = 1.1e-6")
    with pytest.raises(InputError, match=r"1.1e-06 degrees are less than 1e-06 for each of 12 seg"):
        ccgen.parse(text)


LOADED = ["mass", "payload", "tip_force", "tip_moment", "contact"]


@pytest.mark.parametrize("key", LOADED)
def test_loads_too_small_to_bend_the_joint_are_refused(key):
    value = SMALLEST if key == "mass" else f"[0.0, {SMALLEST}]"
    tables = f"[loads]\nsamples = 20\nstiffness = 0.4\n{key} = {value}"
    with pytest.raises(InputError, match=r"joint\.toml: loads: no shape bends axis u; "):
        ccgen.fit(joint(tables=tables, transducer="noise = 2e-5"))


def test_shapes_that_are_given_and_leave_an_axis_straight_are_refused():
    bent = np.full((3, 12), 0.01)
    with pytest.raises(ArgumentError, match="shapes: no shape bends axis v; give some that do"):
        ccgen.fit(joint(), shapes={"u": bent, "v": 0.0 * bent})


@pytest.mark.parametrize("segments", [1, 2, 3, 12, 64])
@pytest.mark.parametrize("case", CASES)
def test_the_reach_that_a_refusal_names_is_reached(segments, case):
    try:
        shape_library(segments, math.radians(90.0), 4, [case])
        return
    except ReachError as refused:
        said = str(refused)
    reach = float(said.split(" reaches ")[1].split(" degrees")[0])
    library = shape_library(segments, math.radians(reach), 4, [case])
    assert library.angles[:, 0].max() == pytest.approx(math.radians(reach), rel=1e-15)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("radians", [5e-324, 1e-300, 1e-150, 1e-99, 1e-50])
def test_a_first_segment_bends_as_little_as_one_likes(case, radians):
    angles = single_shape(3, case, radians)
    assert abs(angles[0] - radians) < 1e-100
    assert np.isfinite(angles).all()


def test_one_segment_of_90_degrees_is_told_how_far_it_bends():
    with pytest.raises(ReachError, match=r"the only one reaches 89\.9991 degrees"):
        ccgen.fit(joint(segments=1, count=1, range_of_motion=90.0))
    fit = ccgen.fit(joint(segments=1, count=1, range_of_motion=89.999))
    assert fit.errors[0].mean_percent_rom["u"] < 1e-9


@pytest.mark.parametrize("noise", [0.0, 4e-4])
@pytest.mark.parametrize("degrees", [1e-6, 3.0])
def test_no_placement_is_better_than_the_one_that_is_called_proven(noise, degrees):
    library = [shape_library(4, math.radians(degrees), samples) for samples in (6, 4)]
    for sensors in (2, 3):
        problem = Problem(*library, sensors, noise=noise)
        found = search(problem)
        every = np.concatenate(list(covering(problem)))
        best = min(problem.percent(as_spans(spans)) for spans in every)
        if found.optimality == "proven":
            assert found.percent <= best * (1 + 1e-11)
        else:
            assert best < 1e-10


# Fixed point: what does not fit, or costs too much, is told by fit already.


def coarse(**changes):
    return joint(step=0.1, radius=0.05, transducer="range = [-1, 1]", **changes)


def test_a_count_coarser_than_the_movement_is_told_by_fit_and_refused_by_export(tmp_path):
    fit = ccgen.fit(coarse())
    what = "sensor 0 of axis u (span [0, 4]) moves less than half a count"
    assert any(what in warning for warning in fit.warnings)
    with pytest.raises(FormatError, match="moves less than half a count"):
        ccgen.export(fit, tmp_path / "out")


def test_one_sensor_that_counts_too_coarsely_is_named_among_others():
    steps = "[0.1, 2e-6, 2e-6]"
    text = joint_text().replace("metres_per_count = 2e-06", f"metres_per_count = {steps}")
    (said,) = [w for w in ccgen.fit(ccgen.parse(text)).warnings if "half a count" in w]
    assert "sensor 0 of axis u" in said


def test_bits_that_do_not_hold_the_movement_are_told_by_fit_as_export_refuses(tmp_path):
    narrow = joint(bits=8)
    fit = ccgen.fit(narrow)
    with pytest.raises(FormatError) as refused:
        ccgen.export(narrow, tmp_path / "out")
    assert f"{refused.value}; as it is, no fixed point can be exported" in fit.warnings
    assert "sensor 2 of axis u" in str(refused.value)
    assert "bits = 15" in str(refused.value)


def test_a_joint_whose_counts_no_format_holds_is_told_all_the_rest():
    fit = ccgen.fit(joint(bits=8, tables=LOADS, transducer="noise = 2e-5"))
    assert fit.checks.notes == ("the sensors are not checked: no fixed point holds their counts",)
    assert fit.errors
    assert fit.without


def full_range(precision):
    return joint(segments=24, count=8, precision=precision, bits=16, step=1e-5,
                 transducer="range = [-32767, 32767]")  # fmt: skip


def test_fixed_point_that_adds_more_than_a_percent_is_told_by_fit_and_export(tmp_path):
    fit = ccgen.fit(full_range(16))
    bound = fit.model.axis("u").worst_error_percent_rom
    assert bound > 1.0
    told = [warning for warning in fit.warnings if "fixed point adds" in warning]
    assert len(told) == 2
    assert all("precision = 32" in warning for warning in told)
    assert tuple(told) == ccgen.export(fit, tmp_path / "out").doubts
    fine = ccgen.fit(full_range(32))
    assert fine.model.axis("u").worst_error_percent_rom < 1.0
    assert not any("fixed point adds" in warning for warning in fine.warnings)


def test_the_bound_of_fixed_point_that_is_told_is_not_below_the_proven_one():
    fit = ccgen.fit(full_range(16))
    (told,) = [w for w in fit.doubts if "axis u" in w]
    assert float(told.split(" adds up to ")[1].split(" %")[0]) >= (
        fit.model.axis("u").worst_error_percent_rom
    )


# Millimetres in the place of metres.


@pytest.mark.parametrize(
    ("changes", "key", "meant"),
    [
        ({"length": 114.76}, "geometry.length", "114.76 mm are 0.11476"),
        ({"radius": 50.0, "step": 2e-3}, "sensors.radius", "50 mm are 0.05"),
        ({"transducer": "noise = 0.02"}, "sensors.transducer.noise", "0.02 mm are 2e-05"),
        ({"step": 4e-3}, "sensors.transducer.metres_per_count", "0.004 mm are 4e-06"),
    ],
)
def test_a_length_that_looks_like_millimetres_is_told_once_with_its_key(changes, key, meant):
    odd = joint(**changes)
    (said,) = unit_doubts(odd)
    assert said.startswith(f"joint.toml: {key}: ")
    assert said.endswith(meant)
    assert said in ccgen.fit(odd).warnings


def test_a_camera_that_misses_bodies_by_the_joints_length_is_told():
    recorded = '[[recordings]]\nfile = "run.csv"\nstations = { tip = 0.1 }\nposition_noise = '
    fine, odd = (ccgen.parse(joint_text(tables=recorded + noise)) for noise in ("2e-4", "0.2"))
    assert not unit_doubts(fine)
    (said,) = unit_doubts(odd)
    assert said.startswith("joint.toml: recordings[0].position_noise: ")
    assert said.endswith("0.2 mm are 0.0002")


def test_keys_of_one_axis_and_of_one_sensor_are_told_where_they_stand():
    text = joint_text(transducer="noise = 2e-5\n[sensors.v]\nradius = 43.0")
    assert [said.split(": ")[1] for said in unit_doubts(ccgen.parse(text))] == ["sensors.v.radius"]
    listed = """\
name = "arm"
[geometry]
segments = 4
length = 0.2
range_of_motion = 5.0
[sensors.transducer]
metres_per_count = 1e-5
[[sensor]]
name = "a"
span = [0, 3]
angle = 90.0
radius = 0.02
[[sensor]]
name = "b"
span = [0, 3]
angle = 0.0
radius = 20.0
noise = 3.0
"""
    assert [said.split(": ")[1] for said in unit_doubts(ccgen.parse(listed))] == [
        "sensor[1].radius",
        "sensor[1].noise",
    ]


def test_borders_of_spans_in_millimetres_lie_outside_the_joint():
    text = joint_text().replace('placement = "heuristic"\ncount = 3', "spans_m = [[0, 120]]")
    with pytest.raises(InputError, match=r"write metres from 0 at the base to 0.24 at the tip"):
        ccgen.parse(text)


def test_usual_joints_raise_no_doubt():
    for example in ("shoulder", "wrist", "spine"):
        assert unit_doubts(ccgen.load(EXAMPLES / f"{example}.toml")) == ()


def test_every_command_says_what_looks_like_millimetres(tmp_path):
    path = tmp_path / "shoulder.toml"
    path.write_text(joint_text(length=114.76))
    told = f"ccgen: warning: {path}: geometry.length: a joint 114.76 m long is unusual"
    for arguments in (
        ("fit", path),
        ("simulate", path, "--case", "uniform", "--first-segment", 1),
        ("place", path, "--method", "heuristic"),
        ("export", path, "-o", tmp_path / "out"),
    ):
        done = ccgen_run(*arguments)
        assert done.returncode == 0
        assert told in done.stderr
    done = ccgen_run("fit", path, "--json")
    assert json.loads(done.stdout)["warnings"][0] == told.removeprefix("ccgen: warning: ") + (
        "; lengths are in metres, 114.76 mm are 0.11476"
    )
