"""Exported joints with sensors anywhere: the model's bits, zeros that are refused, elongation."""

import ctypes
import json
import tempfile
from pathlib import Path

import numpy as np
import pytest

import ccgen
from ccgen.export.package import export
from ccgen.fixedpoint import Fit
from ccgen.targets.compiler import LEVEL
from ccgen.targets.exported import Exported, open_exported
from ccgen.targets.host import compile_shared
from ccgen.targets.inputs import bus_counts
from ccgen.targets.library import JointLibrary
from ccgen.verify.compare import pose_positions
from ccgen.verify.emulated import verify_core
from ccgen.verify.host import verify_host
from ccgen.verify.plan import Plan, silent

HEAD = """\
name = "{name}"
[geometry]
segments = 12
length = 0.24
range_of_motion = {rom}
{geometry}
[fixed_point]
precision = {precision}
[sensors.transducer]
{transducer}
"""
SENSOR = """\
[[sensor]]
name = "{name}"
{span}
angle = {angle}
radius = {radius}
{more}
"""
RAW = "bits = 12\nsigned = false\nmetres_per_count = 4.0e-5"
SPANS = ((0, 4), (3, 8), (7, 11))


def nine(precision: int) -> str:
    """Nine strings at 120 degrees, over two sections that elongate."""
    bits, step = (16, 2.0e-6) if precision == 16 else (24, 1.0e-8)
    text = HEAD.format(
        name="nine", rom=3.0, geometry="sections = [4, 8]\nelongation = [0.0, 0.05]",
        precision=precision, transducer=f"bits = {bits}\nmetres_per_count = {step}",
    )  # fmt: skip
    return text + "".join(
        SENSOR.format(
            name=f"{'abc'[k]}{g}", span=f"span = [{a}, {b}]", angle=120.0 * k, radius=0.05, more=""
        )
        for g, (a, b) in enumerate(SPANS)
        for k in range(3)
    )


def pairs() -> str:
    """Two opposite pairs, each twice along the joint, one wire of them the other way round."""
    text = HEAD.format(
        name="pairs", rom=6.0, geometry="", precision=16, transducer=f"{RAW}\nzero = 2048"
    )
    return text + "".join(
        SENSOR.format(
            name=f"{name}{k}", span=f"span_m = {span}", angle=angle, radius=0.03,
            more="metres_per_count = -4.0e-5" if name == "left" else "",
        )
        for name, angle in (("right", 0.0), ("top", 90.0), ("left", 180.0), ("bottom", 270.0))
        for k, span in enumerate(([0.0, 0.13], [0.11, 0.24]))
    )  # fmt: skip


def planar() -> str:
    """An arm that bends in a plane, whose zeros nobody knows."""
    text = HEAD.format(
        name="planar", rom=6.0, geometry="", precision=16,
        transducer=f"{RAW}\ngain_tolerance = 0.01",
    )  # fmt: skip
    text += "".join(
        SENSOR.format(name=f"p{k}", span=f"span = {list(span)}", angle=180.0, radius=0.03, more="")
        for k, span in enumerate(SPANS)
    )
    return text + '[estimator]\naxes = ["v"]\n'


def raw() -> str:
    """The paper's two sets with unsigned counts of 12 bits."""
    sets = '[sensors]\nplacement = "heuristic"\ncount = 3\nradius = 0.03\n[sensors.transducer]'
    text = HEAD.format(name="raw", rom=6.0, geometry="", precision=16, transducer=RAW)
    return text.replace("[sensors.transducer]", sets)


def stretched() -> str:
    """Three strings whose counts reach far beyond the shapes, of a joint just below 0.25 m."""
    text = HEAD.format(
        name="stretched", rom=5.0, geometry="elongation = [0.0, 0.04]", precision=16,
        transducer="bits = 16\nmetres_per_count = 2.4e-5\nrange = [-32767, 32767]",
    )  # fmt: skip
    return text + "".join(
        SENSOR.format(name=f"s{k}", span="span = [0, 11]", angle=120.0 * k, radius=0.03, more="")
        for k in range(3)
    )


def sixteen() -> str:
    """As many sensors as a joint may have, all of them over the whole joint."""
    text = HEAD.format(
        name="sixteen", rom=3.0, geometry="elongation = [-0.02, 0.03]", precision=16,
        transducer="bits = 16\nmetres_per_count = 2.0e-6",
    )  # fmt: skip
    return text + "".join(
        SENSOR.format(
            name=f"s{k}",
            span=f"span = [{k % 4}, {11 - k % 3}]",
            angle=22.5 * k,
            radius=0.04,
            more="",
        )
        for k in range(16)
    )


JOINTS = {
    "nine, 16 bits": nine(16),
    "nine, 32 bits": nine(32),
    "pairs": pairs(),
    "planar": planar(),
    "raw": raw(),
    "sixteen": sixteen(),
    "stretched": stretched(),
}


@pytest.fixture(scope="module")
def exports(tmp_path_factory):
    """Every joint with its fit, exported once for all tests here."""
    found: dict[str, tuple[Fit, Exported]] = {}

    def one(name: str) -> tuple[Fit, Exported]:
        if name not in found:
            folder = tmp_path_factory.mktemp("joint") / "out"
            fitted = ccgen.fit(ccgen.parse(JOINTS[name]))
            export(fitted, folder)
            found[name] = fitted, open_exported(folder)
        return found[name]

    return one


@pytest.mark.parametrize("name", JOINTS)
def test_every_value_equals_the_model_over_every_transport(exports, name):
    _, exported = exports(name)
    runs = verify_host(exported, Plan(snapshots=60, values=30_000), silent, LEVEL)
    for run in runs:
        assert (run.mismatches, run.lost_frames, run.note) == (0, 0, ""), run.transport
        assert run.compared_values >= 60 * exported.model.values
        assert 0.0 < run.pose_max_error_m <= run.pose_bound_m
    assert runs[0].compared_values >= 30_000


def test_a_tip_beyond_its_frame_is_compared_where_it_saturates(exports):
    _, exported = exports("stretched")
    counts = bus_counts(exported, 300, 0)
    counts = counts[(counts != -(2**15)).all(axis=1)]  # those that miss no reading
    far = pose_positions(exported, exported.model.estimate(counts))
    assert np.abs(far).max() * 2**exported.layout.tip_fraction_bits > 2**15
    for run in verify_host(exported, Plan(snapshots=300, values=1_000), silent, LEVEL):
        assert run.mismatches == 0
        assert run.pose_max_error_m <= run.pose_bound_m, run.transport


@pytest.mark.parametrize(("name", "core"), [("nine, 16 bits", "cortex-m4"), ("raw", "cortex-m0")])
def test_every_value_equals_the_model_on_an_emulated_core(exports, name, core):
    _, exported = exports(name)
    for run in verify_core(exported, core, Plan(snapshots=20, values=10_000), silent):
        assert (run.mismatches, run.lost_frames) == (0, 0)
        assert run.pose_max_error_m <= run.pose_bound_m


@pytest.fixture(scope="module")
def library(exports):
    """The compiled C of a joint, and its own function that checks zeros."""
    with tempfile.TemporaryDirectory(prefix="ccgen-") as place:

        def load(name: str) -> tuple[JointLibrary, ctypes.CDLL]:
            _, exported = exports(name)
            folder = Path(place) / name
            folder.mkdir(exist_ok=True)
            path = compile_shared(exported.directory, folder)
            return JointLibrary(path, exported.model), ctypes.CDLL(str(path))

        yield load


@pytest.mark.parametrize("name", ["nine, 16 bits", "pairs", "raw"])
def test_a_zero_is_refused_by_the_sensor_that_would_run_out_of_counts(exports, library, name):
    _, exported = exports(name)
    batch, functions = library(name)
    readings, joint = exported.model.readings, exported.joint
    check = getattr(functions, f"{joint.name}_check_zero")
    ends = readings.relative.zero_minimum, readings.relative.zero_maximum
    for end, beyond in zip(ends, (-1, 1), strict=True):
        for j, bit in enumerate(exported.layout.missing_bits):
            zero = readings.zero.copy()
            zero[j] = end[j]
            assert check((ctypes.c_int16 * zero.size)(*zero.tolist())) == 0
            counts = np.clip(zero, readings.minimum, readings.maximum)[None]
            _, results = batch.estimate(counts, zero)
            assert results[0] == 0
            zero[j] += beyond
            assert check((ctypes.c_int16 * zero.size)(*zero.tolist())) == 1 << bit
            with pytest.raises(ccgen.errors.ToolError, match="returned -5"):
                batch.estimate(counts, zero)


@pytest.mark.parametrize("name", ["nine, 16 bits", "nine, 32 bits", "pairs", "planar", "raw"])
def test_counts_are_readings_around_any_accepted_zero_and_no_farther(exports, library, name):
    _, exported = exports(name)
    batch, _ = library(name)
    readings = exported.model.readings
    for zero in (readings.relative.zero_minimum, readings.zero, readings.relative.zero_maximum):
        around = readings.around(zero)
        for j in range(readings.sensors):
            for end, beyond in ((around.minimum, -1), (around.maximum, 1)):
                counts = np.stack([zero, zero])
                counts[:, j] = end[j], end[j] + beyond
                values, results = batch.estimate(counts, zero)
                assert results[0] == 0 < results[1]  # an axis that reads it is degraded or lost
                right = exported.model.estimate(counts[:1], zero)
                np.testing.assert_array_equal(values[:1], right)


@pytest.mark.parametrize("name", ["planar", "raw", "nine, 16 bits", "pairs"])
def test_the_float_estimate_agrees_with_the_integers_about_zeros(exports, name):
    fitted, exported = exports(name)
    model = exported.model
    zeros = [sensor.zero for sensor in fitted.sensors]
    assert zeros == model.readings.zero.tolist()
    estimate = fitted.estimate(model.readings.zero[None].astype(float))
    for axis in model.axes:
        assert np.abs(getattr(estimate, axis)).max() < 1e-12
    assert not model.estimate(model.readings.zero).any()


def test_the_header_names_places_of_sensors_and_the_elongation_of_sections(exports):
    _, exported = exports("nine, 16 bits")
    header = (exported.directory / "src" / "nine.h").read_text()
    assert "#define NINE_SENSOR_B1 4\n" in header
    assert "    nine_count_t sensor[NINE_SENSORS];\n" in header
    assert "    nine_angle_t h[NINE_SECTIONS];\n" in header
    _, planar_joint = exports("planar")
    header = (planar_joint.directory / "src" / "planar.h").read_text()
    assert "v[PLANAR_SEGMENTS]" in header
    assert "u[" not in header


def test_the_dbc_gives_lengths_about_the_zero_in_metres(exports):
    _, exported = exports("pairs")
    database = exported.codec  # checks every frame against the DBC
    message = database._entries[exported.layout.base_id].message
    signal = message.get_signal_by_name("length_right0")
    assert signal.scale == 4.0e-5
    assert signal.offset == pytest.approx(-2048 * 4.0e-5)
    last = exported.layout.frames_of("lengths")[-1]
    assert [s.name for s in last.payload][-1] == "length_bottom1"


def test_model_json_holds_what_the_folder_needs(exports):
    _, exported = exports("nine, 16 bits")
    record = json.loads((exported.directory / "model.json").read_text())
    assert list(record["axes"]) == ["u", "v", "h"]
    assert np.shape(record["axes"]["h"]["weights"]) == (2, 9)
