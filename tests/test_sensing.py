"""Simulated sensors: shapes stay within the joint, counts within the transducers' range."""

import numpy as np
import pytest
from joint_files import joint_text

from ccgen.fixedpoint import AxisModel
from ccgen.joint.file import parse_joint
from ccgen.sensing.counts import corner_counts, counts, random_counts
from ccgen.sensing.motion import SOURCES, case_motion, loads_motion, motion, sweep_motion
from ccgen.shapes import ShapeLibrary, Shapes, unstretched

SEGMENTS, ROM = 12, np.radians(3.0)
SPANS = ((0, 4), (3, 8), (7, 11))
CASES = ("uniform", "end-force")


def axis_model(name, minimum, maximum, zero):
    n = len(minimum)
    return AxisModel(
        axis=name,
        precision=16,
        weights=np.zeros((SEGMENTS, n), dtype=np.int64),
        bias=np.zeros(SEGMENTS, dtype=np.int64),
        shift=0,
        fraction_bits=18,
        minimum=np.array(minimum),
        maximum=np.array(maximum),
        zero=np.array(zero),
        saturates=False,
        headroom_bits=1,
        worst_error_percent_rom=0.0,
        rms_error_percent_rom=0.0,
    )


U = axis_model("u", [-9000, -8000, -9000], [9000, 8000, 9000], [0, 100, -7])
V = axis_model("v", [-50, -60, -70], [70, 60, 50], [0, 0, 0])
JOINT = parse_joint(joint_text(), "shoulder.toml")


def library():
    amplitudes = np.linspace(-ROM, ROM, 9)
    fade = np.linspace(1.0, 0.2, SEGMENTS)
    uniform = np.outer(amplitudes, np.ones(SEGMENTS))
    return ShapeLibrary(
        np.concatenate([uniform, np.outer(amplitudes, fade)]),
        ("uniform",) * 9 + ("end-force",) * 9,
        np.tile(amplitudes, 2),
        ROM,
    )


@pytest.mark.parametrize("source", SOURCES)
def test_every_motion_stays_within_the_range_of_motion_and_moves_smoothly(source):
    shapes = motion(source, library(), 4000, 500, seed=3)
    for angles in (shapes.u, shapes.v):
        assert angles.shape == (4000, SEGMENTS)
        assert np.abs(angles).max() <= ROM * (1 + 1e-12)
        assert np.ptp(angles[:, 0]) > 0.5 * ROM
        assert np.abs(np.diff(angles, axis=0)).max() < 0.1 * ROM


def test_random_shapes_repeat_with_their_seed_and_differ_between_axes():
    first, again = (motion("random", library(), 50, 50, seed=5) for _ in range(2))
    other = motion("random", library(), 50, 50, seed=6)
    np.testing.assert_array_equal(first.u, again.u)
    assert np.abs(first.u - other.u).max() > 0.01 * ROM
    assert np.abs(first.u - first.v).max() > 0.01 * ROM


def test_one_turn_through_the_cases_meets_every_shape_of_the_library():
    shapes = case_motion(library(), np.arange(18) / 18)
    wanted = {tuple(row) for row in library().angles.round(12)}
    assert {tuple(row) for row in shapes.u.round(12)} == wanted
    assert {tuple(row) for row in shapes.v.round(12)} == wanted


def test_the_sweep_reaches_full_range_and_bends_all_segments_alike():
    shapes = sweep_motion(library(), np.linspace(0, 2, 1601))
    bend = np.hypot(shapes.u, shapes.v)
    assert bend.max() == pytest.approx(ROM)
    np.testing.assert_array_equal(np.ptp(shapes.u, axis=1), 0)


def test_a_motion_through_loads_rests_at_every_shape_and_keeps_between_them():
    random = np.random.default_rng(1)
    bends = random.uniform(-ROM, ROM, (2, 16, SEGMENTS))
    drawn = Shapes(*bends, random.uniform(0.0, 0.1, (16, 2)), ("loads",) * 16)
    shapes = loads_motion(drawn, np.arange(2048) / 1024, seed=4)
    for values, own in ((shapes.u, drawn.u), (shapes.v, drawn.v), (shapes.h, drawn.h)):
        assert {tuple(row) for row in values[::128]} == {tuple(row) for row in own}
        assert (values >= own.min(axis=0) - 1e-15).all()
        assert (values <= own.max(axis=0) + 1e-15).all()
        assert np.abs(np.diff(values, axis=0)).max() < 0.016 * np.ptp(own)
        np.testing.assert_allclose(values[1::128], values[::128], atol=4e-4 * np.ptp(own))
    again = loads_motion(drawn, np.arange(2048) / 1024, seed=4)
    np.testing.assert_array_equal(again.u, shapes.u)
    assert (loads_motion(drawn, np.arange(2048) / 1024, seed=5).u != shapes.u).any()


def test_an_unknown_source_is_refused():
    with pytest.raises(ValueError, match="unknown source 'circle'; known: cases, random, sweep"):
        motion("circle", library(), 1, 1)


def test_counts_are_the_span_angle_times_radius_over_the_step():
    angles = np.arange(SEGMENTS) * 1e-3
    result = counts(JOINT, (U, V), unstretched(angles[None], 0 * angles[None]))
    sums = [angles[a : b + 1].sum() for a, b in SPANS]
    wanted = [round(0.05 * s / 2e-6) + z for s, z in zip(sums, [0, 100, -7], strict=True)]
    assert result.tolist() == [[*wanted, 0, 0, 0]]


def test_counts_are_clipped_to_the_declared_range():
    full = np.full((1, SEGMENTS), ROM)
    assert counts(JOINT, (U, V), unstretched(full, -full)).tolist() == [
        [6545, 7954, 6538, -50, -60, -70]
    ]


def test_random_counts_fill_the_range_and_both_its_ends():
    values = random_counts((U, V), 20_000)
    assert values.shape == (20_000, 6)
    np.testing.assert_array_equal(values[:, 3:].min(axis=0), V.minimum)
    np.testing.assert_array_equal(values[:, 3:].max(axis=0), V.maximum)
    assert (values[:, :3] >= U.minimum).all()
    assert (values[:, :3] <= U.maximum).all()
    assert np.abs(values[:, :3].mean(axis=0)).max() < 150


def test_corners_hold_every_combination_of_every_axis_and_the_zeros():
    narrow = axis_model("v", [-50, -60], [70, 60], [0, 0])
    values = corner_counts((U, narrow))
    assert values.shape == (10, 5)
    assert len({tuple(row) for row in values[:8, :3]}) == 8
    assert {tuple(row) for row in values[:8, 3:]} == {
        (-50, -60), (-50, 60), (70, -60), (70, 60),
    }  # fmt: skip
    assert values[8:].tolist() == [[0, 100, -7, 0, 0], [1, 101, -6, 1, 1]]
