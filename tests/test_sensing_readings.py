"""Length changes of sensors anywhere, against the kinematics; and the noise of readings."""

import math
from dataclasses import replace

import numpy as np
import pytest
from joint_files import joint_text

from ccgen.joint import Sensor
from ccgen.joint.file import parse_joint
from ccgen.joint.places import sensor_key
from ccgen.kinematics import tendon_length
from ccgen.sensing.noise import length_variance, reading_noise, stated_noise
from ccgen.sensing.readings import length_changes, normaliser, reading_matrix, response
from ccgen.shapes import Shapes, joined, unstretched

PAPER = parse_joint(joint_text(transducer="noise = 2.0e-5"), "shoulder.toml")


def sensor(name, start, end, degrees, **keys):
    values = {"radius": 0.05, "metres_per_count": 2e-6, "bits": 16, **keys}
    return Sensor(name, start, end, math.radians(degrees), **values)


ANYWHERE = replace(
    PAPER,
    sensors=(
        sensor("near", 0.0, 5.0, 30.0, radius=0.02),
        sensor("middle", 1.25, 8.5, 250.0, noise=1e-4, gain_tolerance=0.02),
        sensor("far", 0.0, 12.0, 270.0, metres_per_count=-1e-5),
    ),
    geometry=replace(PAPER.geometry, sections=(4, 8), elongation=(0.0, 0.05)),
    axes=("u", "v", "h"),
    parts=((0, 3), (0, 3), (0, 3)),
    u=None,
    v=None,
)


def states(joint, count=20):
    random = np.random.default_rng(1)
    m, sections = joint.geometry.segments, len(joint.geometry.sections)
    return Shapes(
        random.uniform(-0.1, 0.1, (count, m)),
        random.uniform(-0.1, 0.1, (count, m)),
        random.uniform(0.0, 0.05, (count, sections)),
        ("drawn",) * count,
    )


def test_length_changes_are_those_of_tendons_along_the_stretched_joint():
    shapes, h0 = states(ANYWHERE), ANYWHERE.geometry.segment_length
    stretched = h0 * (1 + np.repeat(shapes.h, (4, 8), axis=1))
    for j, (shares, one) in enumerate(
        zip(
            ([1] * 5 + [0] * 7, [0, 0.75, *[1] * 6, 0.5, 0, 0, 0], [1] * 12),
            ANYWHERE.sensors,
            strict=True,
        )
    ):
        lengths = tendon_length(shapes.u, shapes.v, stretched, one.radius, one.angle)
        np.testing.assert_allclose(
            length_changes(ANYWHERE, shapes.state)[:, j], (lengths - h0) @ shares, atol=1e-15
        )


def test_the_response_matrix_gives_the_same_length_changes():
    state = states(ANYWHERE).state
    H = response(ANYWHERE)
    assert H.shape == (3, 2 * 12 + 2)
    np.testing.assert_allclose(state @ H.T, length_changes(ANYWHERE, state), atol=1e-16)


def test_the_papers_sets_read_their_own_axis_alone_and_exactly():
    H = response(PAPER)
    spans = PAPER.u.spans
    wanted = normaliser(PAPER)[:3, None] * reading_matrix(12, spans)
    np.testing.assert_allclose(H[:3, :12], wanted, rtol=1e-15)
    np.testing.assert_allclose(H[3:, 12:24], wanted, rtol=1e-15)
    assert not H[:3, 12:24].any()
    assert not H[3:, :12].any()
    assert [PAPER.own(axis) for axis in PAPER.axes] == [slice(0, 3), slice(3, 6)]
    assert [one.name for one in PAPER.sensors] == ["u0", "u1", "u2", "v0", "v1", "v2"]


def test_an_axis_that_is_not_estimated_has_no_part_of_the_sensors():
    with pytest.raises(ValueError, match="axis 'h' is not estimated; known: u, v"):
        PAPER.own("h")
    with pytest.raises(ValueError, match="no set of sensors for axis u alone"):
        ANYWHERE.axis("u")


def test_a_sensor_names_the_key_that_its_value_comes_from():
    listed = replace(ANYWHERE, own_keys=frozenset({"sensor[0].bits"}))
    keys = [sensor_key(listed, j, key) for j, key in ((0, "bits"), (0, "range"), (1, "bits"))]
    assert keys == ["sensor[0].bits", "sensors.transducer.range", "sensors.transducer.bits"]


def test_noise_is_what_is_stated_and_what_counting_and_gains_add():
    assert stated_noise(ANYWHERE) is None
    np.testing.assert_array_equal(stated_noise(PAPER), 2e-5)
    np.testing.assert_allclose(reading_noise(PAPER, "v"), 2e-5 / (0.05 * np.array([5, 6, 5])))
    state = states(ANYWHERE, 4000).state
    moment = state.T @ state / len(state)
    wanted = np.array([2e-6**2 / 12, 1e-8 + 2e-6**2 / 12, 1e-10 / 12])
    np.testing.assert_allclose(length_variance(ANYWHERE), wanted)
    wanted[1] += 0.02**2 * np.mean(np.square(length_changes(ANYWHERE, state)[:, 1]))
    np.testing.assert_allclose(length_variance(ANYWHERE, moment), wanted)


def test_shapes_are_rows_of_states_with_a_source_each():
    bent = unstretched(np.ones((2, 3)), np.zeros((2, 3)), 2, "cases")
    stretched = Shapes(np.zeros((1, 3)), np.zeros((1, 3)), [[0.1, 0.2]], ("loads",))
    both = joined([bent, stretched])
    assert (len(both), both.segments, both.sections) == (3, 3, 2)
    assert both.source == ("cases", "cases", "loads")
    assert both.state.tolist() == [[1] * 3 + [0] * 5] * 2 + [[0] * 6 + [0.1, 0.2]]
    with pytest.raises(ValueError, match="read-only"):
        both.u[0, 0] = 1.0
    with pytest.raises(ValueError, match=r"\(2, 3\), \(2, 4\), \(2, 1\) with 2 sources"):
        unstretched(np.ones((2, 3)), np.ones((2, 4)))
