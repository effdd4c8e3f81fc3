"""Loads drawn from ranges, and the shapes under them."""

import dataclasses

import numpy as np
import pytest
from joint_files import joint_text

from ccgen.errors import ReachError
from ccgen.joint.file import parse_joint
from ccgen.joint.loads import Contact, LoadRanges, StatedLoads
from ccgen.shapes.loads.drawn import drawn_shapes
from ccgen.shapes.loads.draws import GRAVITY, draw_loads
from ccgen.shapes.loads.library import loads_library, shortfall
from ccgen.shapes.loads.stated import shape_under

LENGTH = 0.24
ROM = np.radians(3.0)

FINGER = LoadRanges(
    samples=40,
    stiffness=0.4,
    stiffness_profile=(2.0, 1.0, 1.0, 2.5),
    stiffness_tolerance=0.1,
    actuation=(-np.pi / 2, np.pi / 2),
    mass=0.4,
    payload=(0.0, 0.25),
    tip_force=(0.0, 6.0),
    tip_moment=(0.0, 0.2),
    contact=(0.0, 6.0),
    contact_from=0.05,
    elongation=(0.0, 0.03),
)


def ranges(**changes):
    return dataclasses.replace(LoadRanges(samples=40, stiffness=0.4), **changes)


def shapes(stated, sections=(6, 6), range_of_motion=ROM):
    return drawn_shapes(stated, sections, LENGTH, range_of_motion)


def as_stated(shapes, i):
    """One drawn set as loads that are stated, scaled as it was."""
    loads, factor = shapes.loads, shapes.factor[i]
    return StatedLoads(
        stiffness=1.0,
        stiffness_profile=tuple(loads.stiffness[:, i]),
        actuation=tuple(factor * loads.actuation[:, i]),
        tip_force=tuple(factor * loads.tip_force[:, i]),
        tip_moment=tuple(factor * loads.tip_moment[:, i]),
        distributed=tuple(loads.weight[:, i]),
        contacts=(
            Contact(LENGTH * loads.contact_place[i], tuple(factor * loads.contact_force[:, i])),
        ),
        elongation=tuple(loads.elongation[:, i]),
    )


def test_drawn_shapes_are_equilibria_of_their_scaled_loads_within_the_range():
    drawn = shapes(FINGER)
    assert drawn.shapes.u.shape == drawn.shapes.v.shape == (40, 12)
    assert drawn.shapes.h.shape == (40, 2)
    largest = np.maximum(np.abs(drawn.shapes.u), np.abs(drawn.shapes.v)).max(axis=1)
    assert largest.max() <= ROM
    scaled = drawn.factor < 1
    assert 10 < scaled.sum() < 40
    np.testing.assert_allclose(largest[scaled], ROM, rtol=1e-8)
    for i in range(8):
        shape = shape_under(as_stated(drawn, i), (6, 6), LENGTH)
        off = shape.state[0] - drawn.shapes.state[i]
        assert np.abs(off).max() < 1e-3 * largest[i]
        np.testing.assert_array_equal(shape.h[0], drawn.shapes.h[i])


def test_the_same_ranges_give_the_same_draws_and_more_samples_begin_alike():
    few, again, more = (
        shapes(FINGER),
        shapes(FINGER),
        shapes(dataclasses.replace(FINGER, samples=50)),
    )
    assert few.shapes.u.tobytes() == again.shapes.u.tobytes()
    np.testing.assert_allclose(more.shapes.v[:40], few.shapes.v, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(more.loads.stiffness[:, :40], few.loads.stiffness)


def test_scaling_leaves_mass_mounting_and_elongation_alone():
    weak = shapes(FINGER)
    strong = shapes(dataclasses.replace(FINGER, contact=(0.0, 600.0), tip_force=(0.0, 600.0)))
    for name in ("weight", "elongation", "stiffness"):
        np.testing.assert_array_equal(getattr(strong.loads, name), getattr(weak.loads, name))
    assert strong.factor.mean() < 0.2
    np.testing.assert_array_equal(strong.shapes.h, weak.shapes.h)


def test_draws_fill_their_ranges_evenly():
    draws = draw_loads(FINGER, LENGTH, 2, 512)

    def fills(values, low, high):
        assert low <= values.min() < low + 0.01 * (high - low)
        assert high - 0.01 * (high - low) < values.max() <= high
        np.testing.assert_allclose(values.mean(), (low + high) / 2, atol=0.01 * (high - low))

    fills(draws.actuation, -np.pi / 2, np.pi / 2)
    fills(draws.elongation, 0.0, 0.03)
    fills(draws.contact_place, 0.05 / LENGTH, 1.0)
    fills(np.linalg.norm(draws.contact_force, axis=0), 0.0, 6.0)
    fills(np.linalg.norm(draws.tip_moment, axis=0), 0.0, 0.2)
    np.testing.assert_allclose(
        np.linalg.norm(draws.weight, axis=0), 0.4 * GRAVITY / LENGTH, rtol=1e-12
    )
    # On the sphere every coordinate is uniform (Archimedes).
    for direction in (draws.weight / (0.4 * GRAVITY / LENGTH), draws.contact_force / 6.0):
        assert np.abs(direction.mean(axis=1)).max() < 0.02
    for axis in draws.weight / (0.4 * GRAVITY / LENGTH):
        assert np.mean(axis**2) == pytest.approx(1 / 3, abs=0.02)


def test_stiffness_varies_log_normally_by_part():
    draws = draw_loads(FINGER, LENGTH, 1, 1024)
    logarithm = np.log(draws.stiffness / (0.4 * np.array(FINGER.stiffness_profile)[:, None]))
    np.testing.assert_allclose(logarithm.mean(axis=1), 0.0, atol=0.005)
    np.testing.assert_allclose(logarithm.std(axis=1), 0.1, rtol=0.05)
    assert np.abs(np.corrcoef(logarithm) - np.eye(4)).max() < 0.1
    assert draw_loads(ranges(stiffness_tolerance=0.1), LENGTH, 1, 8).stiffness.shape == (4, 8)
    alike = draw_loads(ranges(), LENGTH, 1, 8).stiffness
    np.testing.assert_array_equal(alike, np.full((1, 8), 0.4))


def test_payload_hangs_along_gravity_and_the_tip_force_acts_across_the_axis():
    draws = draw_loads(
        ranges(mass=0.2, mounting=np.radians(60.0), payload=(0.5, 0.5)), LENGTH, 1, 8
    )
    np.testing.assert_allclose(draws.tip_force, draws.weight * LENGTH / 0.2 * 0.5, rtol=1e-12)
    np.testing.assert_allclose(draws.tip_force[2], 0.25 * GRAVITY, rtol=1e-12)
    assert np.std(np.arctan2(draws.tip_force[1], draws.tip_force[0])) > 1.0
    across = draw_loads(ranges(tip_force=(2.0, 2.0)), LENGTH, 1, 8).tip_force
    assert np.all(across[2] == 0.0)
    np.testing.assert_allclose(np.linalg.norm(across, axis=0), 2.0, rtol=1e-12)


def test_a_joint_that_hangs_still_is_straight():
    drawn = shapes(ranges(mass=1.0, mounting=0.0))
    assert np.all(drawn.shapes.u == 0.0)
    assert np.all(drawn.factor == 1.0)


def test_draws_that_buckle_are_counted_and_replaced_by_others():
    standing = shapes(ranges(mass=6.0, mounting=np.pi))
    assert (standing.drawn, standing.buckled, len(standing.shapes)) == (160, 160, 0)
    # A soft joint in any direction: what stands buckles, or lies beyond the range by its weight.
    some = shapes(ranges(mass=1.6, actuation=(-0.5, 0.5)))
    assert some.drawn == len(some.shapes) + some.buckled + some.out_of_range
    assert some.out_of_range > 0
    assert len(some.shapes) == 40


def test_loads_may_bring_back_a_joint_that_its_weight_bends_too_far():
    horizontal = {"mass": 1.5, "mounting": np.pi / 2}
    alone = shapes(ranges(**horizontal))
    assert (len(alone.shapes), alone.out_of_range) == (0, 160)
    lifted = shapes(ranges(**horizontal, actuation=(-0.6, 0.6)))
    assert 0 < len(lifted.shapes) < 40
    assert np.maximum(np.abs(lifted.shapes.u), np.abs(lifted.shapes.v)).max() <= ROM


@pytest.mark.parametrize(("sections", "degrees"), [((1,), 90.0), ((2,), 40.0), ((32, 32), 1.0)])
def test_any_number_of_segments_bends(sections, degrees):
    stated = dataclasses.replace(FINGER, samples=16)
    drawn = shapes(stated, sections, np.radians(degrees))
    assert drawn.shapes.u.shape == (16, sum(sections))
    assert np.maximum(np.abs(drawn.shapes.u), np.abs(drawn.shapes.v)).max() <= np.radians(degrees)


def finger(loads, **changes):
    return parse_joint(joint_text(tables=f"[loads]\n{loads}", **changes), "finger.toml")


def test_a_joint_gives_rows_of_its_stated_loads():
    joint = finger("samples = 20\nstiffness = 0.4\nmass = 0.3\nactuation = [-60, 60]\n")
    drawn = loads_library(joint)
    assert len(drawn.shapes) == 20
    assert set(drawn.shapes.source) == {"loads"}
    assert shortfall(drawn, 20) is None
    assert loads_library(parse_joint(joint_text(), "finger.toml")) is None


def test_a_joint_that_buckles_at_every_draw_is_refused_in_one_line():
    joint = finger("samples = 5\nstiffness = 0.4\nmass = 8\nmounting = 180\n")
    with pytest.raises(ReachError) as error:
        loads_library(joint)
    assert str(error.value) == (
        "finger.toml: loads: of 20 draws 20 buckle; write smaller loads or a larger loads.stiffness"
    )
    lying = finger("samples = 5\nstiffness = 0.4\nmass = 2\nmounting = 90\n")
    with pytest.raises(ReachError) as error:
        loads_library(lying)
    assert str(error.value) == (
        "finger.toml: loads: of 20 draws 20 bend beyond the range of motion by weight alone; write "
        "a smaller loads.mass, a larger loads.stiffness or geometry.range_of_motion"
    )


def test_loads_under_which_hardly_any_draw_gives_a_shape_are_soon_given_up():
    heavy = ranges(samples=4096, stiffness=0.003, mass=0.06, tip_moment=(0.0, 0.5))
    drawn = shapes(heavy)
    assert drawn.drawn == 256
    assert 10 * len(drawn.shapes) < drawn.drawn
    assert "of 256 draws" in shortfall(drawn, 4096)


def test_fewer_shapes_than_wanted_are_told():
    drawn = loads_library(finger("samples = 30\nstiffness = 0.4\nmass = 3\n"))
    found = len(drawn.shapes)
    assert 0 < found < 30
    assert drawn.drawn == 120
    assert shortfall(drawn, 30) == (
        f"{found} of 30 shapes: of 120 draws {120 - found} bend beyond the range of motion by "
        "weight alone"
    )
