"""`ccgen simulate`: what it prints agrees with the geometry, and wrong input is refused."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text

from ccgen.cli.choices import Axis, Case
from ccgen.cli.main import main
from ccgen.joint import AXES, CASES
from ccgen.joint.file import parse_joint, read_joint
from ccgen.sensing.simulation import simulate

EXAMPLES = Path(__file__).parent.parent / "examples"
SHOULDER = str(EXAMPLES / "shoulder.toml")
WRIST = str(EXAMPLES / "wrist.toml")


def ccgen(*arguments: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


def bend(case: str, degrees: float, *more: str, joint: str = SHOULDER) -> list[str]:
    return ["simulate", joint, "--case", case, "--first-segment", str(degrees), *more]


def test_the_options_know_the_joints_words():
    assert tuple(Axis) == AXES
    assert tuple(Case) == CASES


def test_json_holds_a_constant_curvature_in_closed_form(capsys):
    assert ccgen(*bend("constant-curvature", 2.0, "--json")) == 0
    out, err = capsys.readouterr()
    result = json.loads(out)
    assert err == ""
    assert result["segment_angles_deg"]["u"] == pytest.approx([2.0] * 12, rel=1e-14)
    assert result["segment_angles_deg"]["v"] == [0.0] * 12
    bending = math.radians(2.0)
    lengths = [p * (0.02 + 0.05 * bending) for p in (5, 6, 5)]
    assert result["sensor_lengths_m"]["u"] == pytest.approx(lengths, rel=1e-14)
    assert result["sensor_lengths_m"]["v"] == pytest.approx([0.10, 0.12, 0.10], rel=1e-14)
    assert result["sensor_counts"]["u"] == [round(p * 0.05 * bending / 2e-6) for p in (5, 6, 5)]
    assert result["sensor_counts"]["v"] == [0, 0, 0]
    total, radius = 12 * bending, 0.24 / (12 * bending)
    pose = np.eye(4)
    pose[1:3, 1:3] = [[math.cos(total), -math.sin(total)], [math.sin(total), math.cos(total)]]
    pose[1:3, 3] = [-radius * (1 - math.cos(total)), radius * math.sin(total)]
    np.testing.assert_allclose(result["tip_pose"], pose, atol=1e-15)


SQUARE = """
name = "square"
[geometry]
segments = 12
length = 0.24
range_of_motion = 3.0
[sensors.transducer]
metres_per_count = 2e-6
bits = 14
signed = false
zero = 8000
[[sensor]]
name = "front"
span = [0, 11]
angle = 270.0
radius = 0.05
metres_per_count = -2e-5
[[sensor]]
name = "slanted"
span_m = [0.0, 0.13]
angle = 120.0
radius = 0.03
[[sensor]]
name = "left"
span = [0, 11]
angle = 0.0
radius = 0.03
"""


def test_sensors_that_are_listed_are_told_by_name_with_raw_counts(capsys, tmp_path):
    path = tmp_path / "square.toml"
    path.write_text(SQUARE)
    assert ccgen(*bend("constant-curvature", 2.0, "--json", joint=str(path))) == 0
    out, err = capsys.readouterr()
    result, bending = json.loads(out), math.radians(2.0)
    changes = {"front": -12 * 0.05 * bending, "slanted": 6.5 * 0.03 * math.sqrt(0.75) * bending}
    assert result["sensor_lengths_m"] == pytest.approx(
        {"front": 0.24 + changes["front"], "slanted": 0.13 + changes["slanted"], "left": 0.24},
        rel=1e-14,
    )
    assert result["sensor_counts"] == {
        "front": 8000 + round(changes["front"] / -2e-5),
        "slanted": 8000 + round(changes["slanted"] / 2e-6),
        "left": 8000,
    }
    assert err == ""
    assert result["elongation"] == [0.0]


def test_a_count_without_sign_that_falls_below_zero_is_said(capsys, tmp_path):
    path = tmp_path / "square.toml"
    path.write_text(SQUARE.replace("zero = 8000", "zero = 1000"))
    assert ccgen(*bend("constant-curvature", 2.0, joint=str(path))) == 0
    assert "transducer cannot give" not in capsys.readouterr().err
    assert ccgen(*bend("constant-curvature", -2.0, joint=str(path))) == 0
    assert "sensor slanted: its transducer cannot give a count of -1947" in capsys.readouterr().err


def test_a_planar_arm_bends_in_its_own_axis_and_lists_no_other_sensors(capsys, tmp_path):
    path = tmp_path / "planar.toml"
    path.write_text(joint_text(tables='[estimator]\naxes = ["v"]'))
    assert ccgen(*bend("constant-curvature", 2.0, "--json", joint=str(path))) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["segment_angles_deg"]["v"] == pytest.approx([2.0] * 12)
    assert result["sensor_counts"]["u"] == []
    assert len(result["sensor_counts"]["v"]) == 3


def test_a_drawing_shows_the_sensors_wherever_they_are(tmp_path):
    path, drawing = tmp_path / "square.toml", tmp_path / "square.svg"
    path.write_text(SQUARE)
    assert ccgen(*bend("uniform", 2.0, "--plot", str(drawing), joint=str(path))) == 0
    assert drawing.stat().st_size > 1000


def test_the_other_axis_may_bend_and_both_may_differ(capsys):
    assert ccgen(*bend("end-force", -3.0, "--axis", "v", "--json", joint=WRIST)) == 0
    result = json.loads(capsys.readouterr().out)
    angles = np.radians(result["segment_angles_deg"]["v"])
    assert angles[0] == pytest.approx(math.radians(-3.0), rel=1e-12)
    assert result["segment_angles_deg"]["u"] == [0.0] * 8
    assert result["sensor_counts"]["u"] == [0, 0, 0, 0]
    changes = np.array([0.025 * angles[:4].sum(), 0.025 * angles[4:].sum()])
    np.testing.assert_allclose(result["sensor_lengths_m"]["v"], 0.06 + changes, rtol=1e-13)
    assert result["sensor_counts"]["v"] == np.rint(changes / 1.6e-5).tolist()
    assert result["tip_pose"][0][3] < 0


def test_the_table_shows_every_sensor_and_segment(capsys):
    assert ccgen(*bend("uniform", 1.0)) == 0
    out = capsys.readouterr().out
    for sensor in ("u0", "u2", "v0", "v2"):
        assert sensor in out
    assert "1.000000" in out
    assert "Tip pose" in out


@pytest.mark.parametrize(
    ("case", "degrees", "says"),
    [
        ("uniform", "nan", "--first-segment: nan is no angle of a segment; give degrees"),
        ("end-force", "91", "--first-segment: 91 is no angle of a segment; give degrees"),
        ("s-shape", "60", "--first-segment: load case s-shape: a first segment at 60 degrees"),
    ],
)
def test_angles_out_of_reach_are_refused_in_one_line(capsys, case, degrees, says):
    assert ccgen(*bend(case, degrees, "--json")) == 2  # type: ignore[arg-type]
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"ccgen: error: {says}")
    assert err.count("\n") == 1


@pytest.mark.parametrize("wrong", [["--case", "torsion"], ["--axis", "w"]])
def test_unknown_words_are_refused(capsys, wrong):
    assert ccgen("simulate", SHOULDER, "--case", "uniform", "--first-segment", "1", *wrong) == 2
    assert f"'{wrong[1]}' is not one of" in capsys.readouterr().err


def test_what_a_joint_should_not_do_is_said_beside_the_result(capsys):
    assert ccgen(*bend("constant-curvature", 6.0, "--json", joint=WRIST)) == 0
    out, err = capsys.readouterr()
    assert err == "ccgen: 6 degrees is beyond the range of motion of 5\n"
    assert json.loads(out)["sensor_counts"]["u"][1] == round(4 * 0.03 * math.radians(6) / 4e-6)


def test_counts_beyond_the_transducer_are_named():
    text = (EXAMPLES / "shoulder.toml").read_text()
    joint = parse_joint(text.replace("[shapes]", "range = [-100, 6000]\n[shapes]"), "x")
    assert simulate(joint, "constant-curvature", 0.05).out_of_range == (0, 1, 2)
    assert simulate(joint, "constant-curvature", 0.05, "v").out_of_range == (3, 4, 5)
    assert simulate(joint, "end-force", 0.05).out_of_range == ()
    assert simulate(joint, "end-force", -0.05).out_of_range == (0, 1, 2)
    narrow = parse_joint(text.replace("bits = 16", "bits = 12"), "x")
    assert simulate(narrow, "end-force", 0.05).out_of_range == (0, 1)
    assert simulate(read_joint(Path(SHOULDER)), "end-force", 0.05).out_of_range == ()


@pytest.mark.parametrize("name", ["shape.svg", "shape.PNG"])
def test_the_plot_is_the_same_bytes_each_time(capsys, tmp_path, name):
    files = [tmp_path / "a" / name, tmp_path / "b" / name]
    for file in files:
        assert ccgen(*bend("s-shape", 2.0, "--json", "--plot", str(file))) == 0
        out, err = capsys.readouterr()
        assert "tip_pose" in json.loads(out)
        assert err == f"ccgen: wrote {file}\n"
    data = files[0].read_bytes()
    assert data == files[1].read_bytes()
    assert data.startswith(b"<?xml" if name.endswith("svg") else b"\x89PNG")
    assert str(tmp_path).encode() not in data


def test_a_plot_of_unknown_format_is_refused(capsys, tmp_path):
    assert ccgen(*bend("uniform", 1.0, "--plot", str(tmp_path / "a.pdf"))) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.endswith("a.pdf: unknown format; give a name that ends in .svg or .png\n")
    assert list(tmp_path.iterdir()) == []


PUSH = """
stiffness = 0.4
tip_force = [5.0, 9.0, -3.0]
distributed = [0.0, 0.0, -4.0]
actuation_u = 20.0
contacts = [{ at = 0.1, force = [-2.0, 1.0, 0.0] }]
elongation = 0.03
"""


def push(tmp_path, text=PUSH):
    file = tmp_path / "push.toml"
    file.write_text(text)
    return str(file)


def under(loads, *more, joint=SHOULDER):
    return ["simulate", joint, "--loads", loads, *more]


def test_json_of_stated_loads_holds_the_shape_and_what_sensors_make_of_it(capsys, tmp_path):
    turning = "actuation_u = 24.0\nactuation_v = -12.0\nelongation = [0.05]\n"
    assert ccgen(*under(push(tmp_path, turning), "--json")) == 0
    out, err = capsys.readouterr()
    result = json.loads(out)
    assert err == ""
    assert result["segment_angles_deg"]["u"] == pytest.approx([2.0] * 12, rel=1e-12)
    assert result["segment_angles_deg"]["v"] == pytest.approx([-1.0] * 12, rel=1e-12)
    assert result["elongation"] == [0.05]
    spans = np.array([5, 6, 5])
    for axis, degrees in (("u", 2.0), ("v", -1.0)):
        changes = spans * (0.05 * math.radians(degrees) + 0.05 * 0.02)
        np.testing.assert_allclose(
            result["sensor_lengths_m"][axis], 0.02 * spans + changes, rtol=1e-12
        )
        assert result["sensor_counts"][axis] == np.rint(changes / 2e-6).tolist()
    # An arc in one plane of 26.83 degrees over the elongated length.
    u, v = math.radians(24.0), math.radians(-12.0)
    total = math.hypot(u, v)
    across = 1.05 * 0.24 / total * (1 - math.cos(total)) / total
    tip = [row[3] for row in result["tip_pose"][:3]]
    expected = [across * v, -across * u, 1.05 * 0.24 / total * math.sin(total)]
    np.testing.assert_allclose(tip, expected, rtol=1e-12)


def test_stated_loads_give_a_table_and_say_what_lies_beyond_the_range(capsys, tmp_path):
    assert ccgen(*under(push(tmp_path))) == 0
    out, err = capsys.readouterr()
    assert "elongation / %" in out
    assert "3.000000" in out
    assert err == (
        "ccgen: segment 0 bends by -5.05 degrees in u, beyond the range of motion of 3\n"
        "ccgen: segment 0 bends by 3.19 degrees in v, beyond the range of motion of 3\n"
    )


@pytest.mark.parametrize("name", ["shape.svg", "shape.png"])
def test_the_plot_in_space_is_the_same_bytes_each_time(capsys, tmp_path, name):
    files = [tmp_path / "a" / name, tmp_path / "b" / name]
    for file in files:
        assert ccgen(*under(push(tmp_path), "--json", "--plot", str(file))) == 0
    assert capsys.readouterr().err.endswith(f"ccgen: wrote {files[1]}\n")
    data = files[0].read_bytes()
    assert data == files[1].read_bytes()
    assert data.startswith(b"<?xml" if name.endswith("svg") else b"\x89PNG")


def test_a_plot_without_forces_is_drawn_too(tmp_path):
    bent = push(tmp_path, "actuation_v = 10.0\n")
    assert ccgen(*under(bent, "--json", "--plot", str(tmp_path / "arc.svg"))) == 0
    assert (tmp_path / "arc.svg").stat().st_size > 1000


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "stiffness = 0.4\ntip_force = [0.0, 0.0, -100.0]",
            "at 0.171 of these loads the joint buckles; lower them or raise stiffness",
        ),
        (
            "stiffness = 0.4\ntip_force = [1e6, 0.0, 0.0]",
            "of these loads segment 0 is bent by 90 degrees; lower them or raise stiffness",
        ),
        ("stiffness = 0.4\nat = 1.0", "at: unknown key here; write it in [[contacts]]"),
        (
            "elongation = [0.1, 0.1]",
            "elongation: [0.1, 0.1] has 2 numbers; write one for each of the joint's sections,"
            " here 1",
        ),
    ],
)
def test_loads_that_cannot_be_are_refused_in_one_line(capsys, tmp_path, text, says):
    file = push(tmp_path, text)
    assert ccgen(*under(file, "--json")) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"ccgen: error: {file}: ")
    assert err.endswith(f"{says}\n")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--case", "uniform"], "--case: belongs to a load case; give it or loads, not both"),
        (["--first-segment", "1"], "--first-segment: belongs to a load case; give it or loads"),
        (["--axis", "v"], "--axis: belongs to a load case; give it or loads, not both"),
    ],
)
def test_stated_loads_exclude_a_load_case(capsys, tmp_path, options, says):
    assert ccgen(*under(push(tmp_path), *options)) == 2
    assert capsys.readouterr().err.startswith(f"ccgen: error: {says}")


def test_half_a_load_case_is_told_what_it_lacks(capsys):
    choices = "missing; give a case with the angle of the first segment, or loads\n"
    assert ccgen("simulate", SHOULDER) == 2
    assert capsys.readouterr().err == f"ccgen: error: --case: {choices}"
    assert ccgen("simulate", SHOULDER, "--case", "uniform") == 2
    assert capsys.readouterr().err == f"ccgen: error: --first-segment: {choices}"
