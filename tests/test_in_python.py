"""`import ccgen`: from a joint to estimates and C without the command line."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text

import ccgen
from ccgen.errors import ArgumentError, InputError
from ccgen.fixedpoint import load_model
from ccgen.joint import CASES
from ccgen.kinematics import tip_pose
from ccgen.placement import Constraints, Search
from ccgen.sensing.counts import raw_counts
from ccgen.shapes import bent_alike, fit_shapes, score_library, unstretched
from ccgen.targets.exported import open_exported

ROOT = Path(__file__).resolve().parent.parent
SHOULDER = ROOT / "examples" / "shoulder.toml"


@pytest.fixture(scope="module")
def joint():
    return ccgen.load(str(SHOULDER))


@pytest.fixture(scope="module")
def fit(joint):
    return ccgen.fit(joint)


@pytest.fixture(scope="module")
def bent(joint):
    """Rows that differ between the axes."""
    angles = score_library(joint).angles
    return unstretched(angles, -0.5 * angles[::-1])


def python(program: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def test_importing_it_imports_nothing_of_it():
    program = "import sys, ccgen; print([n for n in sys.modules if n.startswith('ccgen.')])"
    assert python(program) == "[]"
    heavy = {"numpy", "scipy", "pydantic", "casadi", "matplotlib", "can", "jinja2", "asyncio"}
    assert python(f"import sys, ccgen; print({heavy} & set(sys.modules))") == "set()"


def test_every_public_name_is_there():
    assert set(ccgen.__all__) <= set(dir(ccgen))
    for name in ccgen.__all__:
        assert getattr(ccgen, name) is not None
    with pytest.raises(AttributeError, match="'ccgen' has no attribute 'fits'"):
        _ = ccgen.fits


@pytest.mark.parametrize("before", ["", "import ccgen.export.package", "from ccgen import export"])
def test_a_room_can_be_called_whatever_was_imported_before(tmp_path, before):
    folder = tmp_path / "shoulder"
    python(f"{before}\nimport ccgen\nccgen.export({str(SHOULDER)!r}, {str(folder)!r})")
    assert (folder / "manifest.json").is_file()


def test_a_joint_is_read_from_a_file_or_from_text(joint):
    assert ccgen.parse(SHOULDER.read_text()) == joint
    with pytest.raises(InputError, match=r"^joint\.toml: name: missing"):
        ccgen.parse("[geometry]\nsegments = 3\nlength = 0.1\nrange_of_motion = 2.0")
    with pytest.raises(ArgumentError, match=r"^text: is no text; .* load its path"):
        ccgen.parse(SHOULDER)
    with pytest.raises(InputError, match=r"nowhere\.toml: no such file"):
        ccgen.load("nowhere.toml")


def test_the_estimate_finds_the_shape_and_the_tip(joint, fit, bent):
    estimate = fit.estimate(raw_counts(joint, bent))
    errors = [np.abs(estimate.u - bent.u).mean(), np.abs(estimate.v - bent.v).mean()]
    assert max(errors) < 3e-4 * joint.geometry.range_of_motion
    assert estimate.h.tolist() == [[0.0]] * len(bent)
    poses = tip_pose(estimate.u, estimate.v, joint.geometry.segment_length)
    np.testing.assert_array_equal(estimate.tip, poses[:, :3, 3])
    with pytest.raises(ValueError, match="read-only"):
        estimate.u[0, 0] = 0.0


def test_integers_and_floats_estimate_the_same_within_the_proven_bound(joint, fit, bent):
    counts = raw_counts(joint, bent)
    angles = fit.model.estimate(counts)
    estimate = fit.estimate(counts)
    for axis, floats, integers in zip(
        "uv", (estimate.u, estimate.v), np.split(angles, 2, 1), strict=True
    ):
        model = fit.model.axis(axis)
        bound = model.worst_error_percent_rom / 100 * joint.geometry.range_of_motion
        assert np.abs(model.radians(integers) - floats).max() <= bound


def test_two_readings_that_are_missing_lose_their_axis_alone(joint, fit, bent):
    counts = raw_counts(joint, bent)[:3].astype(float)
    whole = fit.estimate(counts)
    counts[0, :2] = np.nan
    counts[1, 3:5] = np.nan, 2**15
    estimate = fit.estimate(counts)
    assert np.isnan(estimate.u).all(axis=1).tolist() == [True, False, False]
    assert np.isnan(estimate.v).all(axis=1).tolist() == [False, True, False]
    assert np.isnan(estimate.tip).all(axis=1).tolist() == [True, True, False]
    np.testing.assert_array_equal(estimate.v[0], whole.v[0])
    np.testing.assert_array_equal(estimate.u[1], whole.u[1])


def test_a_reading_that_is_missing_costs_its_axis_the_error_that_was_told(joint, fit):
    shapes = fit.stated.shapes
    counts = raw_counts(joint, shapes).astype(float)
    whole = fit.estimate(counts)
    for j, told in enumerate(fit.without):
        gone = counts.copy()
        gone[:, j] = np.nan if j % 2 else 2**15
        estimate = fit.estimate(gone)
        axis, other = "uv" if j < 3 else "vu"
        np.testing.assert_array_equal(getattr(estimate, other), getattr(whole, other))
        error = np.degrees(getattr(estimate, axis) - getattr(shapes, axis))
        assert np.sqrt(np.mean(np.square(error))) == pytest.approx(told.rms_deg[axis], rel=0.05)
        assert not np.isnan(estimate.tip).any()


def test_without_fallbacks_a_missing_reading_loses_its_axis():
    fit = ccgen.fit(ccgen.parse(joint_text(tables="[estimator]\nfallback = false")))
    estimate = fit.estimate([[np.nan, 100, 100, 100, 100, 100]])
    assert np.isnan(estimate.u).all()
    assert not np.isnan(estimate.v).any()


def test_zeros_and_gains_are_those_that_the_fit_shows(bent):
    text = joint_text(transducer="zero = 2048\nsigned = false", step=-3e-5, bits=12, radius=0.05)
    described = ccgen.parse(text)
    fit = ccgen.fit(described)
    assert [(one.zero, one.metres_per_count) for one in fit.sensors] == [(2048, -3e-5)] * 6
    straight = fit.estimate(np.full((1, 6), 2048))
    assert not straight.u.any()
    assert not straight.v.any()
    shape = bent_alike(0.5 * bent.u, 1)
    estimate = fit.estimate(raw_counts(described, shape))
    assert np.abs(estimate.u - shape.u).max() < 0.02 * described.geometry.range_of_motion


@pytest.mark.parametrize(
    ("counts", "problem"),
    [
        ([[1, 2, 3]], r"counts: have shape \(1, 3\), not \(N, 6\); .* order u0, u1, u2, v0"),
        ([1, 2, 3, 4, 5, 6], r"counts: have shape \(6,\)"),
        ([["a"] * 6], "counts: are no array of numbers"),
        ([[0.0, 1e-3, -2e-4, 0.0, 0.0, np.nan]], r"all below 1, as lengths .* \(0\.001\)"),
    ],
)
def test_counts_that_cannot_be_are_refused(fit, counts, problem):
    with pytest.raises(ArgumentError, match=problem):
        fit.estimate(counts)


def test_shapes_may_be_given_in_every_form(joint, fit):
    rows = fit_shapes(joint)
    for shapes in (rows, rows.u, rows.u.tolist(), {"u": rows.u, "v": rows.v}):
        other = ccgen.fit(joint, shapes=shapes)
        np.testing.assert_array_equal(other.weights["v"].matrix, fit.weights["v"].matrix)
    halves = {"u": rows.u, "v": rows.u * np.linspace(0.5, 1.0, 12)}
    other = ccgen.fit(joint, "noise-aware", halves)
    assert other.method == other.weights["u"].method == "noise-aware"
    assert not np.array_equal(other.weights["u"].matrix, other.weights["v"].matrix)
    told = [(row.source, row.held_out) for row in other.errors[::2]]
    assert told == [("cases", True), ("given", False), ("other loads", True)]


def test_errors_tell_the_papers_score_without_and_with_noise(fit):
    plain, noisy = fit.errors[:2]
    assert (plain.source, plain.noise, noisy.noise) == ("cases", False, True)
    assert not plain.held_out
    assert plain.mean_percent_rom["u"] == pytest.approx(0.010475, rel=1e-3)
    assert noisy.mean_percent_rom["u"] > 10 * plain.mean_percent_rom["u"]
    (warning,) = fit.warnings
    assert warning.startswith("the weights are fitted to the load cases alone")


def test_shapes_beyond_the_range_are_kept_and_said(joint):
    straight = np.zeros((1, 12))
    fit = ccgen.fit(joint, shapes=straight + 1.5 * joint.geometry.range_of_motion)
    assert fit.warnings[-1].startswith("the shapes reach 1.5 times the range of motion")
    assert fit.model.u.radians(fit.model.u.angle_limit) > 1.5 * joint.geometry.range_of_motion


def test_formats_hold_the_range_of_motion_where_the_shapes_given_do_not_reach_it(joint):
    small = ccgen.fit(joint, shapes=0.01 * fit_shapes(joint).u)
    straight_to_farthest = bent_alike(np.full((1, 12), joint.geometry.range_of_motion))
    counts = raw_counts(joint, straight_to_farthest)
    angles = small.model.u.radians(small.model.u.estimate(counts[:, :3]))
    np.testing.assert_allclose(angles, joint.geometry.range_of_motion, rtol=0.02)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda u: np.degrees(u), r"shapes: u reaches too far: .* as degrees would be; .*radians"),
        (lambda u: u.T, r"shapes: u has shape \(12, 5\), not \(N, 12\); .* its transpose has"),
        (lambda u: u[:, :7], r"shapes: u has shape \(5, 7\), not \(N, 12\)"),
        (lambda u: u[0], r"shapes: u has shape \(12,\)"),
        (lambda u: u[:0], "shapes: hold no row"),
        (lambda u: np.where(u == u[2, 3], np.nan, u), r"shapes: u\[\d, \d\] is nan; leave out"),
        (lambda u: np.full_like(u, 2.0), "as degrees would be"),
        (lambda u: np.full_like(u, 50.0), "2.86 times|more than 90 degrees a segment"),
        (lambda u: {"u": u}, 'shapes: lack the axis "v"'),
        (lambda u: {"u": u, "v": u[:3]}, "shapes: have 5 of u, 3 of v rows"),
        (lambda u: {"u": u, "w": u}, 'shapes: have an axis "w"'),
        (lambda u: {"u": u, "v": u, "h": np.full((5, 1), 3.0)}, "h reaches 3, .* share of the"),
        (lambda u: {"u": u, "v": u, "h": np.full((5, 1), 0.1)}, "does not elongate"),
        (lambda u: [["x"] * 12], "u is no array of numbers"),
        (lambda u: ccgen.Shapes(u[:, :5], u[:, :5], np.zeros((5, 1)), ("a",) * 5), "not .N, 12"),
    ],
)
def test_shapes_that_are_not_the_joints_are_refused(joint, change, problem):
    with pytest.raises(ArgumentError, match=problem):
        ccgen.fit(joint, shapes=change(fit_shapes(joint).u[:5].copy()))


def test_one_array_is_refused_where_sensors_read_both_axes():
    sensors = "\n".join(
        f'[[sensor]]\nname = "s{j}"\nspan = [0, 11]\nangle = {120 * j}.0\nradius = 0.05\n'
        for j in range(3)
    )
    text = joint_text().partition("[sensors]")[0] + sensors
    text += "[sensors.transducer]\nmetres_per_count = 2e-6\n"
    described = ccgen.parse(text)
    with pytest.raises(ArgumentError, match=r'shapes: are one array, .*"u": ..., "v"'):
        ccgen.fit(described, shapes=np.zeros((3, 12)))


def test_an_unknown_method_is_refused(joint):
    with pytest.raises(ArgumentError, match="method: 'best' is unknown; give one of direct, equal"):
        ccgen.fit(joint, "best")


def test_simulated_counts_come_back_as_the_shape(joint, fit):
    simulation = ccgen.simulate(joint, "end-force", 0.04, "v")
    estimate = fit.estimate(simulation.counts[None])
    assert not estimate.u.any()
    np.testing.assert_allclose(estimate.v[0], simulation.v, atol=1e-4)
    np.testing.assert_allclose(estimate.tip[0], simulation.tip_pose[:3, 3], atol=1e-4)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"case": "end-force", "first_segment": 2.5}, "first_segment: .* as degrees would be"),
        ({"case": "end-force", "first_segment": 1.0}, "first_segment: .* as degrees would be"),
        ({"case": "s-shape", "first_segment": 1.0, "far": True}, "out of reach"),
        ({"case": "end-force", "first_segment": float("nan")}, "first_segment: nan is no angle"),
        ({"case": "sag", "first_segment": 0.01}, "case: 'sag' is unknown; known: end-force"),
        ({"case": "uniform", "first_segment": 0.01, "axis": "h"}, "axis: 'h' is unknown"),
        ({"case": "uniform"}, "first_segment: missing; give a case with the angle"),
        ({}, "case: missing; give a case with the angle of the first segment, or loads"),
        ({"loads": "push.toml", "case": "uniform"}, "case: belongs to a load case"),
        ({"loads": "push.toml"}, r"push\.toml: no such file"),
    ],
)
def test_what_cannot_be_simulated_is_said(joint, arguments, problem):
    with pytest.raises(InputError, match=problem):
        ccgen.simulate(joint, **arguments)


def test_every_load_case_can_be_simulated(joint):
    for case in CASES:
        assert ccgen.simulate(joint, case, 0.02).u[0] == pytest.approx(0.02)


def test_what_is_exported_is_what_was_fitted(joint, tmp_path):
    fit = ccgen.fit(joint, "equal", 1.5 * fit_shapes(joint).u)
    done = ccgen.export(fit, str(tmp_path / "arm"))
    exported = open_exported(done.directory)
    written = load_model(tmp_path / "arm" / "model.json")
    for axis in "uv":
        np.testing.assert_array_equal(written.axis(axis).weights, fit.model.axis(axis).weights)
    assert 'method "equal"' in (tmp_path / "arm" / "src" / "shoulder.h").read_text()
    assert exported.joint == joint
    inputs = json.loads((tmp_path / "arm" / "manifest.json").read_text())["inputs"]
    assert sorted(inputs) == ["joint.toml", "shapes"]
    assert "| error on given shapes (eq. 12)" in (tmp_path / "arm" / "README.md").read_text()


def test_a_path_a_joint_and_its_fit_export_the_same_bytes(joint, fit, tmp_path):
    written = []
    for one in (SHOULDER, joint, fit):
        ccgen.export(one, tmp_path / "shoulder")
        written.append((tmp_path / "shoulder" / "manifest.json").read_bytes())
    assert written[0] == written[1] == written[2]


def test_a_joint_that_its_file_does_not_describe_is_not_exported(joint, tmp_path):
    changed = replace(joint, geometry=replace(joint.geometry, length=0.5))
    with pytest.raises(ArgumentError, match=r"is not what its file says, .*; change the text"):
        ccgen.export(changed, tmp_path / "shoulder")
    assert list(tmp_path.iterdir()) == []


def test_placements_are_compared_for_both_axes_at_once(joint):
    (placed,) = ccgen.place(joint, sensors=3, constraints=Constraints(longest=8))
    assert (placed.table, placed.axes, placed.estimator) == ("sensors", ("u", "v"), "noise-aware")
    assert placed.best.method == "search"
    assert placed.best.optimality == "proven"
    assert [one.method for one in placed.found][-2:] == ["evolutionary", "search"]
    assert placed.refused == ()
    (alone,) = ccgen.place(joint, 3, "heuristic", "v", "angles")
    assert (alone.table, alone.estimator) == ("sensors.v", "noise-aware")
    assert alone.best.spans == joint.v.spans


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"sensors": 9}, "sensors: 9 sensors on an axis; a joint file takes 1 to 8"),
        ({"method": "best"}, "method: 'best' is unknown; give one of single"),
        ({"axis": "w"}, "axis: 'w' is unknown; give one of u, v"),
        ({"objective": "reach"}, "objective: 'reach' is unknown; give one of paper, angles, tip"),
        ({"constraints": Constraints(stacked=0)}, "stacked: at most 0 sensors"),
        ({"search": Search(starts=0)}, "starts: 0 is too small; give at least 1"),
        ({"sensors": 1, "constraints": Constraints(longest=3)}, "no placement of 1 sensor"),
    ],
)
def test_what_cannot_be_placed_is_said(joint, arguments, problem):
    with pytest.raises(InputError, match=problem):
        ccgen.place(joint, **arguments)


@pytest.fixture(scope="module")
def folder(fit, tmp_path_factory):
    return ccgen.export(fit, tmp_path_factory.mktemp("python") / "shoulder").directory


def test_a_folder_is_verified(folder):
    done = ccgen.verify(str(folder), snapshots=50, values=2000, optimise="0")
    assert done.passed
    assert done.changed == ()
    assert [run.transport for run in done.runs] == ["batch", "virtual", "slcan-pty"]


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"target": "z80"}, "target: z80 is unknown; known: host, .*, all"),
        ({"optimise": "9"}, "optimise: '9' is unknown; give one of 0, s, 2, 3"),
        ({"snapshots": 0}, "snapshots: 0 is too small"),
        ({"values": -1}, "values: -1 is too small"),
        ({"seed": -1}, "seed: -1 is too small"),
    ],
)
def test_what_cannot_be_verified_is_said(folder, arguments, problem):
    with pytest.raises(ArgumentError, match=problem):
        ccgen.verify(folder, **arguments)


def test_a_folder_is_measured(folder):
    done = ccgen.cost(folder, "cortex-m4", optimise="s")
    (cost,) = done.targets
    assert (cost.target, cost.level, done.left_out) == ("cortex-m4", "-Os", {})
    assert 0 < cost.times.estimate < cost.times.snapshot
    with pytest.raises(ArgumentError, match="target: z80 is unknown; known: host, cortex-m0"):
        ccgen.cost(folder, ["z80"])
    with pytest.raises(InputError, match=r"manifest\.json: No such file"):
        ccgen.cost(folder.parent, "cortex-m4")
